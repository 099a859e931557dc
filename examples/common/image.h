// Pictures of floats: linear Rec. 709 radiance, three channels, row 0 at the top.
#ifndef IMAGE_H
#define IMAGE_H

#include "file.h"
#include "vec.h"

typedef struct image {
    int width, height;
    float *rgb; // [(y * width + x) * 3 + channel]; from malloc
} image;

// A black picture; false only when memory runs out or the size is not 1..32768.
bool image_create(image *im, int width, int height);
void image_free(image *im);

// Radiance .hdr (RGBE, plain or either run-length coding, EXPOSURE and COLORCORR undone) and .pfm
// (PF, Pf or PF4, either byte order, any dialect of its header), told apart by their first bytes,
// not by their names. Values of a PFM are kept as they stand: negative ones, infinities and NaN.
bool image_load(image *im, const char *path, message *why);
bool image_decode(image *im, const unsigned char *bytes, size_t size, message *why);

bool image_save_pfm(const image *im, const char *path, message *why);

static inline vec3 image_get(const image *im, int x, int y)
{
    return vec_of(im->rgb + ((size_t)y * (size_t)im->width + (size_t)x) * 3);
}

static inline void image_set(image *im, int x, int y, vec3 value)
{
    float *rgb = im->rgb + ((size_t)y * (size_t)im->width + (size_t)x) * 3;
    rgb[0] = value.x;
    rgb[1] = value.y;
    rgb[2] = value.z;
}

// a becomes the mean of a and b, which has the same size.
void image_average(image *a, const image *b);

// Root mean square of the difference of all values of two pictures of the same size.
float image_rms(const image *a, const image *b);

// The exposure that brings the median luminance to a middle grey.
float image_exposure(const image *im);

// exposure x radiance -> film curve -> sRGB bytes, three a pixel. NaN becomes black.
void image_tonemap(const image *im, float exposure, unsigned char *rgb8);

// By the end of its name a .pfm of the radiance as it is, or a PNG as below.
bool image_save(const image *im, float exposure, const char *path, message *why);

// image_tonemap and png_write in one.
bool image_save_png(const image *im, float exposure, const char *path, message *why);

#endif
