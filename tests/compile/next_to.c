// Both headers with their implementations in one file with somebody else's OpenGL header, which
// tests/compile.sh names: before them, or after them with -DLAST.
#if !defined LAST
#include OTHER
#endif
#define MSSM_IMPLEMENTATION
#define LIGHTPROBE_IMPLEMENTATION
#include "mssm.h"
#include "lightprobe.h"
#if defined LAST
#include OTHER
#endif

// The other header's names still mean what they did.
static GLenum names[2] = {GL_RGBA32I, GL_TEXTURE_2D_ARRAY};

int main(void)
{
    const GLuint none = 0;
    return !(names[0] == 0x8D82 && names[1] == 0x8C1A && none == 0 &&
             mssm_gl_create(0, 0) != MSSM_OK);
}
