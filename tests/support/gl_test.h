// What tests on OpenGL begin with: a context, and shaders that compile without a word.
#ifndef GL_TEST_H
#define GL_TEST_H

#include "../../examples/common/gl_context.h"

// False where there is no context: the test is skipped, or has failed if TEST_REQUIRE_GL is set.
bool gl_test_begin(gl_context *c);

// Whether a log of a shader or program is as it should be: without a word on Mesa, where these
// tests are run every day. Other drivers have words for a success, too ("No errors.", statistics).
bool gl_test_quiet(const char *log);

// A second context that shares the objects of the first, which stays current, and what makes either
// current. False, with a line that says so, where the contexts are not made by EGL.
bool gl_test_share(const gl_context *c, gl_context *shared);
bool gl_test_make_current(const gl_context *c);
void gl_test_unshare(gl_context *shared);

// Whether this GPU rounds quotients and roots as IEEE 754 says. GLSL lets quotients
// be 2.5 units off, roots more: then a decision between two lights that are almost alike falls
// otherwise, and all lights after it are other ones.
bool gl_test_rounds(void);

// From now on, in this context, quotients and roots in shaders are off by up to two units in the last
// place, other than by powers of two: GLSL asks for 2.5 of quotients and for less of roots, and x / x
// may be less than 1. Drivers without a GPU round as IEEE 754 says. gl_test_begin does it if
// TEST_ROUNDING is set.
void gl_test_round_loosely(void);

// Texts end in NULL and get "#version 450 core" in front. Any word in a log fails the test; 0 if
// the driver makes nothing of it.
GLuint gl_test_shader(GLenum type, const char *name, const char *const *text);
GLuint gl_test_compute(const char *name, const char *const *text); // a program
// Links a program again, which fails: in use it stays as it was, but GL does not take it back.
void gl_test_link_in_vain(GLuint program);

#endif
