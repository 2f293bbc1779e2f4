/* SPDX-License-Identifier: MIT */
/* Reads the planes of textures. A spectral texture keeps only the planes of one pass in memory: its
 * stack may be larger than the memory. */
#include "data/images/inside.h"
#include "data/text/text.h"

/* Returns the texels of level 0. */
static size_t page_size(const struct texture *texture)
{
    return (size_t)texture->image.width * (size_t)texture->image.height;
}

/* Reads a page, its bottom row first. */
static bool plane_read(struct texture *texture, int page, float *plane, struct error *err)
{
    const size_t width = (size_t)texture->image.width;
    if (!image_read(&texture->image, page, 0, texture->image.height, plane, err))
        return false;
    float *low = plane, *high = plane + page_size(texture) - width;
    for (; low < high; low += width, high -= width)
        for (size_t i = 0; i < width; i++) {
            const float kept = low[i];
            low[i] = high[i];
            high[i] = kept;
        }
    return true;
}

static bool plane_allocate(struct texture *texture, int i, struct error *err)
{
    return texture->plane[i] != NULL || MAKE_ARRAY(texture->plane[i], texture->plane_size, err,
                                                   "the texels of %s", texture->image.path);
}

/* Reads all pages, one after the other, into the first plane, to find the extreme values, which
 * averages do not exceed. The last one stays there. */
static bool find_extremes(struct texture *texture, struct error *err)
{
    if (!plane_allocate(texture, 0, err))
        return false;
    texture->smallest = HUGE_VAL;
    for (int page = 0; page < texture->image.n_pages; page++) {
        if (!plane_read(texture, page, texture->plane[0], err))
            return false;
        for (size_t i = 0; i < page_size(texture); i++) {
            const double value = (double)texture->plane[0][i];
            if (value > texture->largest) /* gcc 12 for ARM fails on fmax */
                texture->largest = value;
            if (value < texture->smallest)
                texture->smallest = value;
        }
    }
    mipmaps_make(texture, texture->plane[0]);
    return true;
}

/* A spectral texture loads three planes, with room for one more page, for the reference and for
 * OpenGL; OpenGL gets a copy of four floats a texel. */
bool texture_read(const char *path, struct place from, image_tags *read_tags, struct texture *out,
                  struct error *err)
{
    const double floats = (out->spectral ? 2 * (TEXTURE_PLANES + 1) : 1) + 4;
    const char *what = out->relief ? "relief" : "texture";
    pthread_mutex_init(&out->reading, NULL);
    if (!file_expected(path, from, out->relief ? FILE_RELIEF : FILE_TEXTURE, err) ||
        !image_open(path, from, read_tags, &out->image, err))
        return false;
    mipmaps_count(out);
    if (out->relief) {
        out->image.file->pages->colour = MEAN_COLOUR;
        out->image.file->pages->gamma = 0;
    }
    if (out->image.width > LONGEST_TEXTURE || out->image.height > LONGEST_TEXTURE)
        error_at(err, from, "%s: it has %dx%d pixels; a %s has at most %d a side", path,
                 out->image.width, out->image.height, what, LONGEST_TEXTURE);
    else if (out->rgb && !image_spread(&out->image, err))
        ;
    else if (out->spectral && out->image.wavelengths_nm == NULL)
        error_at(err, from,
                 "%s: %s; expected a stack of this program, or pages that record increasing"
                 " wavelengths as OME-XML, GDAL_METADATA or page names such as \"305 nm\"",
                 path, out->image.no_wavelengths);
    else if (!out->spectral && out->image.n_pages > 1)
        error_at(err, from,
                 "%s: it has %d pages; expected one page for a %s; a stack of pages with"
                 " wavelengths is a spectral-texture",
                 path, out->image.n_pages, what);
    else
        return memory_suffices(floats * sizeof(float) * (double)out->plane_size, from, err,
                               "%s: a %s of %dx%d texels", path, what, out->image.width,
                               out->image.height) &&
               find_extremes(out, err);
    return false;
}

/* Reads the plane of a wavelength. `other` is room for one more page. */
static bool plane_load(struct texture *texture, double nm, float *plane, float *other,
                       struct error *err)
{
    const double *page_nm = texture->image.wavelengths_nm;
    const int last = texture->image.n_pages - 1;
    int page = 0;
    while (page < last && page_nm[page + 1] <= nm)
        page++;
    if (!plane_read(texture, page, plane, err))
        return false;
    if (page == last || nm <= page_nm[page])
        return true;
    if (!plane_read(texture, page + 1, other, err))
        return false;
    const double share = (nm - page_nm[page]) / (page_nm[page + 1] - page_nm[page]);
    for (size_t i = 0; i < page_size(texture); i++)
        plane[i] = (float)((double)plane[i] + share * ((double)other[i] - (double)plane[i]));
    return true;
}

bool texture_fill(struct texture *texture, const double *wavelengths_nm, int n,
                  float *const planes[TEXTURE_PLANES], struct error *err)
{
    float *other;
    bool good = MAKE_ARRAY(other, page_size(texture), err, "texels of %s", texture->image.path);
    pthread_mutex_lock(&texture->reading);
    for (int i = 0; good && i < n; i++) {
        good = plane_load(texture, wavelengths_nm[i], planes[i], other, err);
        if (good)
            mipmaps_make(texture, planes[i]);
    }
    pthread_mutex_unlock(&texture->reading);
    free(other);
    return good;
}

bool texture_load(struct texture *texture, const double *wavelengths_nm, int n, struct error *err)
{
    if (!texture->spectral)
        return true;
    for (int i = 0; i < n; i++)
        if (!plane_allocate(texture, i, err))
            return false;
    return texture_fill(texture, wavelengths_nm, n, texture->plane, err);
}

void texture_free(struct texture *texture)
{
    for (int i = 0; i < TEXTURE_PLANES; i++)
        free(texture->plane[i]);
    image_close(&texture->image);
    *texture = (struct texture){0};
}
