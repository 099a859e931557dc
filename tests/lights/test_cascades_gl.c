// Maps of growing size in a shader: the same as on the CPU, in every map and in the seams between.
#include "../support/gl_test.h"
#include "../support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../../examples/common/cascades.h"
#include "../../examples/common/gl_draw.h"
#include "../../examples/common/raster.h"

enum { WIDTH = 96, HEIGHT = 72, SIDE = 256, MAPS = 3, SAMPLES = 4 };

static const char shading[] =
    "layout(binding = 0) uniform sampler2D position_map;\n"
    "layout(binding = 1) uniform sampler2D normal_map;\n"
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    ivec2 pixel = ivec2(gl_FragCoord.xy);\n"
    "    vec3 n = texelFetch(normal_map, pixel, 0).xyz;\n"
    "    color = vec4(cascades_visibility(texelFetch(position_map, pixel, 0).xyz, n));\n"
    "}\n";

static void draw_maps(mssm_gl *maps, const cascades *c, GLuint depth, const gl_mesh *casters)
{
    for (int i = 0; i < MAPS; i++) {
        CHECK(!mssm_gl_set_light(maps, i, &c->light[i]) && !mssm_gl_begin_depth(maps, i, 0),
              "begin");
        gl.UseProgram(depth);
        gl.ProgramUniformMatrix4fv(depth, 0, 1, GL_FALSE, c->light[i].world_to_shadow);
        gl_mesh_draw(casters);
        CHECK(!mssm_gl_end_depth(maps), "end");
    }
    CHECK(!mssm_gl_build(maps), "build");
}

static void make_maps(mssm_map *map[MAPS], const cascades *c, const scene *s, void *memory)
{
    static float depth[SIDE * SIDE * SAMPLES];
    const size_t bytes = mssm_map_bytes(SIDE, 6);
    for (int i = 0; i < MAPS; i++) {
        const raster_frustum f = {c->light[i].world_to_shadow, false, 0, 0};
        CHECK(!mssm_map_init(&map[i], (char *)memory + (size_t)i * bytes, bytes, SIDE, 6), "init");
        CHECK(raster_depth(s, &f, RASTER_FRONT, SIDE, SAMPLES, depth), "raster");
        CHECK(!mssm_map_update(map[i], depth, NULL, SAMPLES), "update");
    }
}

static void the_shader_is_the_cpu(void)
{
    static float got[4 * WIDTH * HEIGHT], place[2][4 * WIDTH * HEIGHT];
    const mssm_gl_desc maps_desc = {.load = gl_context_function,
                                    .lights = MAPS,
                                    .side = SIDE,
                                    .samples = SAMPLES,
                                    .first_texture_unit = 4};
    const cascades_desc desc = {MAPS,      SIDE,  5,     9, 0.5f, 0.4f, {-0.7f, 1, 0.5f},
                                {1, 0, 0}, 0.05f, 0.05f, 4};
    const camera eye = camera_look(vec(0.3f, 3.4f, 5.6f), vec(-0.05f, 0.6f, 0), 0.66f, 4.0f / 3);
    const float from[3] = {eye.position.x, eye.position.y, eye.position.z};
    const float ahead[3] = {-eye.back.x, -eye.back.y, -eye.back.z};
    const GLenum formats[GL_TARGET_COLORS] = {GL_RGBA32F};
    gl_context context;
    gl_mesh casters = {0}, triangle = {0};
    gl_surfaces surfaces;
    gl_target target = {0};
    mssm_gl *maps = NULL;
    mssm_map *map[MAPS];
    cascades c;
    scene s;
    message why = {""};
    if (!gl_test_begin(&context)) return;
    void *memory = malloc(MAPS * mssm_map_bytes(SIDE, 6));
    if (!memory) abort();
    CHECK(cascades_create(&c, &desc) && scene_create(&s, 0, NULL), "create");
    cascades_aim(&c, from, ahead);
    CHECK(gl_mesh_upload(&casters, &s, &why) &&
              gl_surfaces_create(&surfaces, WIDTH, HEIGHT, &why) &&
              gl_target_create(&target, WIDTH, HEIGHT, 1, formats, &why) &&
              !mssm_gl_create(&maps, &maps_desc),
          "no stage: %s", why.text);
    const GLuint depth = gl_program_simple("depth", gl_depth_vertex, NULL, &why);
    const char *const vertex[] = {gl_triangle_vertex, NULL};
    const char *const fragment[] = {mssm_gl_shader(maps), cascades_glsl, shading, NULL};
    const GLuint program = gl_program("cascades", vertex, fragment, &why);
    CHECK(depth && program, "%s", why.text);
    gl_mesh_triangle(&triangle);
    draw_maps(maps, &c, depth, &casters);
    gl_surfaces_draw(&surfaces, &casters, &eye);
    gl_target_begin(&target);
    gl.UseProgram(program);
    gl.ProgramUniform3fv(program, gl.GetUniformLocation(program, "cascades_eye"), 1, c.eye);
    gl.ProgramUniform1i(program, gl.GetUniformLocation(program, "cascades_count"), MAPS);
    for (int i = 0; i < MAPS; i++) {
        char name[32];
        snprintf(name, sizeof name, "cascades_end[%d]", i);
        gl.ProgramUniform1f(program, gl.GetUniformLocation(program, name), c.end[i]);
    }
    for (GLuint i = 0; i < 2; i++) gl.BindTextureUnit(i, surfaces.target.color[i]);
    CHECK(!mssm_gl_bind(maps), "bind");
    gl_mesh_draw(&triangle);
    gl.GetTextureImage(target.color[0], 0, GL_RGBA, GL_FLOAT, sizeof got, got);
    for (int i = 0; i < 2; i++) {
        gl.GetTextureImage(surfaces.target.color[i], 0, GL_RGBA, GL_FLOAT, sizeof place[i],
                           place[i]);
    }

    make_maps(map, &c, &s, memory);
    double squares = 0;
    int count = 0, seams = 0, dark = 0, used[MAPS] = {0};
    for (int i = 0; i < 4 * WIDTH * HEIGHT; i += 4) {
        const float *p = place[0] + i, *n = place[1] + i;
        float next;
        if (p[3] == 0) continue;
        const int k = cascades_choose(&c, p, &next);
        const float v = mssm_map_visibility_normal(map[k], &c.light[k], NULL, p, n);
        const float after =
            k + 1 < MAPS ? mssm_map_visibility_normal(map[k + 1], &c.light[k + 1], NULL, p, n) : 1;
        squares += pow((double)(v + next * (after - v) - got[i]), 2);
        count++;
        used[k]++;
        seams += next > 0 && next < 1;
        dark += got[i] < 0.5f;
    }
    test_note("rms %.5f over %d pixels, %d %d %d in the maps, %d in seams, %d dark",
              sqrt(squares / count), count, used[0], used[1], used[2], seams, dark);
    CHECK(used[0] > 50 && used[1] > 50 && used[2] > 50 && seams > 100 && dark > 100,
          "not all is seen");
    CHECK(sqrt(squares / count) < 0.01, "rms %.4f", sqrt(squares / count));
    CHECK(gl.GetError() == GL_NO_ERROR, "a GL error is left");
    free(memory);
    mssm_gl_destroy(maps);
    gl_surfaces_free(&surfaces);
    gl_target_free(&target);
    gl_mesh_free(&casters);
    gl_mesh_free(&triangle);
    gl.DeleteProgram(depth);
    gl.DeleteProgram(program);
    scene_free(&s);
    gl_context_destroy(&context);
}

const test_case cascades_gl_tests[] = {
    {"large scenes: the shader is the CPU", the_shader_is_the_cpu},
    {0, 0},
};
