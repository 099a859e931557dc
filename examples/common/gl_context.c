#include "gl_context.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

gl_functions gl;

typedef void (*any_function)(void);

bool gl_load(any_function (*load)(const char *name), const char **missing)
{
    any_function f;
#define GL_LOAD(result, name, parameters) \
    f = load("gl" #name);                 \
    if (!f) {                             \
        *missing = "gl" #name;            \
        return false;                     \
    }                                     \
    gl.name = (result(GL_CALL *) parameters)f;
    GL_FUNCTIONS(GL_LOAD)
#undef GL_LOAD
    return true;
}

#if defined _WIN32

bool gl_context_create(gl_context *c, const char **why)
{
    memset(c, 0, sizeof *c);
    *why = "OpenGL without a window is not available on Windows in these programs";
    return false;
}

bool gl_context_create_portable(gl_context *c, bool es, const char **why)
{
    (void)es;
    return gl_context_create(c, why);
}

void gl_context_destroy(gl_context *c)
{
    memset(c, 0, sizeof *c);
}

any_function gl_context_function(const char *name)
{
    (void)name;
    return NULL;
}

#else

#include <dlfcn.h>

enum {
    EGL_NONE = 0x3038,
    EGL_SURFACE_TYPE = 0x3033,
    EGL_PBUFFER_BIT = 0x0001,
    EGL_RENDERABLE_TYPE = 0x3040,
    EGL_OPENGL_BIT = 0x0008,
    EGL_OPENGL_ES3_BIT = 0x0040,
    EGL_OPENGL_ES_API = 0x30A0,
    EGL_EXTENSIONS = 0x3055,
    EGL_OPENGL_API = 0x30A2,
    EGL_CONTEXT_MAJOR_VERSION = 0x3098,
    EGL_CONTEXT_MINOR_VERSION = 0x30FB,
    EGL_CONTEXT_FLAGS = 0x30FC, // EGL_KHR_create_context, as old drivers know it
    EGL_CONTEXT_DEBUG_BIT = 0x0001,
    EGL_CONTEXT_PROFILE_MASK = 0x30FD,
    EGL_CONTEXT_CORE_PROFILE_BIT = 0x0001,
    EGL_CONTEXT_COMPATIBILITY_PROFILE_BIT = 0x0002,
    EGL_PLATFORM_SURFACELESS_MESA = 0x31DD
};

// The library and its display stay open to the end of the process: drivers leave exit handlers
// behind, and what one keeps in its globals looks like a leak once eglTerminate has unloaded it.
static struct {
    void *library;
    any_function (*GetProcAddress)(const char *name);
    const char *(*QueryString)(void *display, int name);
    void *(*GetDisplay)(void *native);
    void *(*GetPlatformDisplayEXT)(unsigned platform, void *native, const int *attributes);
    unsigned (*Initialize)(void *display, int *major, int *minor);
    unsigned (*BindAPI)(unsigned api);
    unsigned (*ChooseConfig)(void *display, const int *attributes, void **configs, int size,
                             int *count);
    void *(*CreateContext)(void *display, void *config, void *share, const int *attributes);
    unsigned (*MakeCurrent)(void *display, void *draw, void *read, void *context);
    unsigned (*DestroyContext)(void *display, void *context);
    unsigned (*ReleaseThread)(void);
} egl;

// dlsym returns a data pointer; ISO C has no cast from there to a function.
static bool load_symbol(void *function, const char *name)
{
    void *address = dlsym(egl.library, name);
    memcpy(function, &address, sizeof address);
    return address != NULL;
}

static bool load_egl(void)
{
    if (egl.library) return true;
    egl.library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!egl.library) return false;
    const bool complete = load_symbol(&egl.GetProcAddress, "eglGetProcAddress") &&
                          load_symbol(&egl.QueryString, "eglQueryString") &&
                          load_symbol(&egl.GetDisplay, "eglGetDisplay") &&
                          load_symbol(&egl.Initialize, "eglInitialize") &&
                          load_symbol(&egl.BindAPI, "eglBindAPI") &&
                          load_symbol(&egl.ChooseConfig, "eglChooseConfig") &&
                          load_symbol(&egl.CreateContext, "eglCreateContext") &&
                          load_symbol(&egl.MakeCurrent, "eglMakeCurrent") &&
                          load_symbol(&egl.DestroyContext, "eglDestroyContext") &&
                          load_symbol(&egl.ReleaseThread, "eglReleaseThread");
    if (complete) {
        const any_function f = egl.GetProcAddress("eglGetPlatformDisplayEXT");
        memcpy(&egl.GetPlatformDisplayEXT, &f, sizeof f);
        return true;
    }
    dlclose(egl.library);
    egl.library = NULL;
    return false;
}

static bool has_extension(const char *list, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = list; at && (at = strstr(at, name)) != NULL; at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
    return false;
}

// A display that is already initialized, or null. Surfaceless needs neither X nor a graphics card.
static void *open_display(void)
{
    if (egl.GetPlatformDisplayEXT &&
        has_extension(egl.QueryString(NULL, EGL_EXTENSIONS), "EGL_MESA_platform_surfaceless")) {
        void *display = egl.GetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, NULL, NULL);
        if (display && egl.Initialize(display, NULL, NULL)) return display;
    }
    void *display = egl.GetDisplay(NULL);
    return display && egl.Initialize(display, NULL, NULL) ? display : NULL;
}

static void *create_context(void *display)
{
    static const int config_attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                            EGL_OPENGL_BIT, EGL_NONE};
    const int context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                      4,
                                      EGL_CONTEXT_MINOR_VERSION,
                                      5,
                                      EGL_CONTEXT_PROFILE_MASK,
                                      getenv("GL_COMPATIBILITY")
                                          ? EGL_CONTEXT_COMPATIBILITY_PROFILE_BIT
                                          : EGL_CONTEXT_CORE_PROFILE_BIT,
                                      EGL_CONTEXT_FLAGS,
                                      EGL_CONTEXT_DEBUG_BIT,
                                      EGL_NONE};
    void *config = NULL; // stays null where no config fits: EGL_KHR_no_config_context
    int count = 0;
    if (!egl.BindAPI(EGL_OPENGL_API)) return NULL;
    egl.ChooseConfig(display, config_attributes, &config, 1, &count);
    return egl.CreateContext(display, config, NULL, context_attributes);
}

// OpenGL 3.3 core, or OpenGL ES 3.0.
static void *create_portable(void *display, bool es)
{
    const int config_attributes[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                     es ? EGL_OPENGL_ES3_BIT : EGL_OPENGL_BIT, EGL_NONE};
    const int context_attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                      3,
                                      EGL_CONTEXT_MINOR_VERSION,
                                      es ? 0 : 3,
                                      es ? EGL_NONE : EGL_CONTEXT_PROFILE_MASK,
                                      EGL_CONTEXT_CORE_PROFILE_BIT,
                                      EGL_NONE};
    void *config = NULL;
    int count = 0;
    if (!egl.BindAPI(es ? EGL_OPENGL_ES_API : EGL_OPENGL_API)) return NULL;
    egl.ChooseConfig(display, config_attributes, &config, 1, &count);
    return egl.CreateContext(display, config, NULL, context_attributes);
}

typedef enum context_kind { OPENGL_45, OPENGL_33, OPENGL_ES_30 } context_kind;

static bool create(gl_context *c, context_kind kind, const char **why)
{
    memset(c, 0, sizeof *c);
    *why = NULL;
    if (!load_egl()) {
        *why = "libEGL.so.1 is missing: apt-get install libegl1 libgl1-mesa-dri";
        return false;
    }
    c->display = open_display();
    if (!c->display) {
        *why = "EGL finds no driver: apt-get install libgl1-mesa-dri";
        return false;
    }
    c->context = kind == OPENGL_45 ? create_context(c->display)
                                   : create_portable(c->display, kind == OPENGL_ES_30);
    if (!c->context) {
        *why =
            kind == OPENGL_ES_30
                ? "the driver has no OpenGL ES 3.0: apt-get install libgl1-mesa-dri"
            : kind == OPENGL_33
                ? "the driver has no OpenGL 3.3 core: apt-get install libgl1-mesa-dri"
                : "the driver has no OpenGL 4.5 core: apt-get install libgl1-mesa-dri (Mesa 20.2 or "
                  "newer)";
    } else if (!egl.MakeCurrent(c->display, NULL, NULL, c->context)) {
        *why = "the driver cannot work without a window (EGL_KHR_surfaceless_context): "
               "apt-get install libgl1-mesa-dri";
    } else {
        static char line[80];
        const char *missing;
        if (kind != OPENGL_45 || gl_load(gl_context_function, &missing)) return true;
        snprintf(line, sizeof line, "the driver lacks %s: apt-get install libgl1-mesa-dri",
                 missing);
        *why = line;
    }
    gl_context_destroy(c);
    return false;
}

bool gl_context_create(gl_context *c, const char **why)
{
    return create(c, OPENGL_45, why);
}

bool gl_context_create_portable(gl_context *c, bool es, const char **why)
{
    return create(c, es ? OPENGL_ES_30 : OPENGL_33, why);
}

void gl_context_destroy(gl_context *c)
{
    if (c->display) {
        egl.MakeCurrent(c->display, NULL, NULL, NULL);
        if (c->context) egl.DestroyContext(c->display, c->context);
        egl.ReleaseThread();
    }
    memset(c, 0, sizeof *c);
}

any_function gl_context_function(const char *name)
{
    return egl.library ? egl.GetProcAddress(name) : NULL;
}

#endif
