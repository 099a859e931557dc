// Single scattering: any light, camera, rays and moments. Rows, columns and depths are numbers in
// range, visibility is in [0,1], failures change nothing.
//     make fuzz FUZZ=scattering
#include "fuzz_light.h"

static void check_ray(fuzz_input *in, mssm_scattering s)
{
    float n[9];
    for (int i = 0; i < 9; i++) n[i] = fuzz_float(in);
    const mssm_epipolar row = mssm_scattering_row(s, fuzz_tame(in, 7));
    const float r = mssm_scattering_distance(row, n[0]), z = mssm_inclination(s, r, n[1]);
    EXPECT(row.first >= 0 && row.extent >= 0 && row.fade > 0 && r >= row.first && isfinite(r),
           "from %a, %a long, r %a", (double)row.first, (double)row.extent, (double)r);
    EXPECT(z >= -1 && z <= 1, "inclination %a", (double)z);
    const mssm_points2 p = mssm_reconstruct3(n[2], n[3], n[4]);
    EXPECT(p.z[0] >= -1 && p.z[0] <= p.z[1] && p.z[1] <= 1 && p.w[0] >= 0 && p.w[0] <= 1,
           "depths %a %a, share %a", (double)p.z[0], (double)p.z[1], (double)p.w[0]);
    const mssm_moments6 m = mssm_scattering_moments(s, r, n[2], n[3], n[4]);
    check_moments(m, 1);
    if (fuzz_byte(in) & 1) s.balance = fuzz_float(in);
    const mssm_view_ray ray = mssm_scattering_ray(s, n[5], n[6], n[7], n[8]);
    EXPECT(isfinite(ray.row) && ray.column >= 0 && ray.column <= 1.0001f && ray.depth >= -1 &&
               ray.depth <= 1,
           "row %a, column %a, depth %a", (double)ray.row, (double)ray.column, (double)ray.depth);
    const float v = mssm_scattering_visibility(ray, mssm_moments6_bias(m, MSSM_BIAS6_UNORM16));
    EXPECT(v >= 0 && v <= 1, "visibility %a", (double)v);
}

static void check_camera(fuzz_input *in, const mssm_light *light)
{
    float eye[3], corners[12];
    mssm_scattering s, before;
    const int tame = fuzz_byte(in) & 3;
    for (int i = 0; i < 3; i++) eye[i] = tame ? fuzz_tame(in, 4) : fuzz_float(in);
    for (int i = 0; i < 12; i++) corners[i] = tame ? fuzz_unit(in) : fuzz_float(in);
    const float extinction = tame ? fabsf(fuzz_float(in)) : fuzz_float(in);
    memset(&s, 0x5a, sizeof s);
    before = s;
    if (mssm_scattering_init(&s, light, eye, corners, extinction)) {
        EXPECT(!memcmp(&s, &before, sizeof s), "a failure has changed something");
        return;
    }
    EXPECT(!light->perspective && extinction >= 0, "%d, %a", light->perspective,
           (double)extinction);
    for (int i = fuzz_int(in, 1, 6); i > 0; i--) check_ray(in, s);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_input in = {data, size};
    while (in.left > 0) {
        mssm_light light;
        if (make_light(&in, &light)) continue;
        for (int i = fuzz_int(&in, 1, 3); i > 0; i--) check_camera(&in, &light);
    }
    return 0;
}
