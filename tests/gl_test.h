// What tests on OpenGL begin with: a context, and shaders that compile without a word.
#ifndef GL_TEST_H
#define GL_TEST_H

#include "../examples/common/gl_context.h"

// False where there is no context: the test is skipped, or has failed if TEST_REQUIRE_GL is set.
bool gl_test_begin(gl_context *c);

// Texts end in NULL and get "#version 450 core" in front. Any word in a log fails the test; 0 if the
// driver makes nothing of it.
GLuint gl_test_shader(GLenum type, const char *name, const char *const *text);
GLuint gl_test_compute(const char *name, const char *const *text); // a program

#endif
