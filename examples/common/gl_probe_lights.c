#include "gl_probe_lights.h"

#include "gl_context.h"
#include "gl_example.h"

bool gl_probe_lights_create(gl_probe_lights *p, int side, int lights, bool distances, message *why)
{
    const lightprobe_gl_desc from = {
        .load = gl_context_function, .side = side, .max_lights = lights, .distances = distances};
    const mssm_gl_desc maps = {.load = gl_context_function,
                               .lights = lights,
                               .side = 512,
                               .first_buffer_binding = 1,
                               .settings = {.estimator = MSSM_HORIZON}};
    *p = (gl_probe_lights){0};
    if (lights > GL_PROBE_LIGHTS) return fail(why, "at most %d lights", GL_PROBE_LIGHTS);
    if (lightprobe_gl_create(&p->probe, &from)) return fail(why, "no lights from probes");
    if (mssm_gl_create(&p->shadows, &maps)) return fail(why, "no shadow maps");
    p->depth = gl_program_simple("depth", gl_depth_vertex, NULL, why);
    return p->depth != 0;
}

void gl_probe_lights_free(gl_probe_lights *p)
{
    lightprobe_gl_destroy(p->probe);
    mssm_gl_destroy(p->shadows);
    if (p->depth) gl.DeleteProgram(p->depth);
    *p = (gl_probe_lights){0};
}

bool gl_probe_lights_update(gl_probe_lights *p, GLuint cube, vec3 place, vec3 low, vec3 high,
                            const gl_mesh *casters, message *why)
{
    const float from[3] = {place.x, place.y, place.z};
    const float least[3] = {low.x, low.y, low.z}, most[3] = {high.x, high.y, high.z};
    if (lightprobe_gl_update(p->probe, cube) ||
        lightprobe_gl_read(p->probe, 1, p->light, &p->count, NULL)) {
        return fail(why, "no lights in the probe");
    }
    for (int i = 0; i < p->count; i++) {
        const lightprobe_light *l = &p->light[i];
        mssm_light frustum;
        mssm_light_area(&frustum, from, l->direction, l->axis_u, l->tan_half_u, l->tan_half_v,
                        l->distance, least, most);
        gl_example_map(p->shadows, i, &frustum, p->depth, casters);
    }
    return mssm_gl_build(p->shadows) == MSSM_OK || fail(why, "no tables");
}

void gl_probe_lights_bind(const gl_probe_lights *p)
{
    const lightprobe_gl_range lights = lightprobe_gl_lights(p->probe, 1); // as the maps have them
    gl.BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, lights.buffer, lights.offset, lights.bytes);
    mssm_gl_bind(p->shadows);
}
