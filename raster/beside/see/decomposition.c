/* SPDX-License-Identifier: MIT */
/* Takes a picture apart by the reference. The radiance of a pixel in a band is the sum over the
 * terms of its material of weight x spectrum, times its texture. Weights depend on geometry only.
 * Materials share the pages: a pixel shows one. */
#include "raster/beside/see/inside.h"

/* A page of a chunk. */
struct page_chunk {
    const struct decomposition *of;
    const struct lit_scene *lit;
    const struct picture *picture;
    int page;
    float *values; /* of each pixel; owned */
};

size_t picture_pixels(const struct picture *picture)
{
    return (size_t)picture->at.width * (size_t)picture->at.height;
}

int weight_pages(const struct plan *plan)
{
    return 1 + 2 * plan->n_lights;
}

/* Returns the number of pages of a texture. */
static int pages_of(const struct plan *plan, const struct texture *texture, bool own)
{
    return !texture->spectral ? !own : own ? texture->image.n_pages : plan->n_bands;
}

int texture_pages(const struct plan *plan, bool own_wavelengths)
{
    int most = 0;
    for (int i = 0; i < plan->n_textures; i++) {
        const int n = pages_of(plan, &plan->textures[i], own_wavelengths);
        most = n > most ? n : most;
    }
    return most;
}

/* Loads pages of all textures, from `first` on. */
static bool load(const struct page_chunk *chunk, int first, struct error *err)
{
    const struct plan *plan = chunk->lit->plan;
    const bool own = chunk->of->own_wavelengths;
    for (int i = 0; i < plan->n_textures; i++) {
        struct texture *texture = &plan->textures[i];
        const double *nm = own ? texture->image.wavelengths_nm : plan->scene->wavelengths_nm;
        const int left = pages_of(plan, texture, own) - first;
        if (left > 0 &&
            !texture_load(texture, nm + first, left < BANDS_PER_PASS ? left : BANDS_PER_PASS, err))
            return false;
    }
    return true;
}

/* Returns the value of a pixel's texture on its page `page`. */
static double texture_at(const struct page_chunk *chunk, const struct shaded_material *shaded,
                         size_t pixel, int page)
{
    const bool own = chunk->of->own_wavelengths;
    const struct texture *texture = shaded->texture;
    const size_t n = picture_pixels(chunk->picture), across = (size_t)shaded->n_terms * n + pixel;
    double place[TEXEL_PLACE];
    if (!texture || (own && (!texture->spectral || page >= texture->image.n_pages)))
        return own ? 0 : 1;
    const struct texels texels =
        plan_texels(texture, texture->spectral ? page % BANDS_PER_PASS : 0);
    plan_place(&texels, chunk->picture->rows + across, n, place);
    return texel_at(&texels, place);
}

static double value_at(const struct page_chunk *chunk, size_t pixel)
{
    const struct picture *picture = chunk->picture;
    const int texture = chunk->page - weight_pages(chunk->lit->plan);
    if (picture->surface[pixel] < 0)
        return 0;
    const struct shaded_material *shaded = chunk->lit->bounds[picture->surface[pixel]].shaded;
    if (texture >= 0)
        return texture_at(chunk, shaded, pixel, texture);
    for (int t = 0; t < shaded->n_terms; t++) {
        const struct term *term = &shaded->terms[t];
        if (chunk->page == (term->reflection == CONSTANT
                                ? 0
                                : 1 + 2 * term->light + (term->reflection == SPECULAR)))
            return picture->rows[(size_t)t * picture_pixels(picture) + pixel];
    }
    return 0;
}

static bool take_tile(void *context, const struct tile *tile, struct error *err)
{
    struct page_chunk *chunk = context;
    const struct decomposition *of = chunk->of;
    const struct plan *plan = chunk->lit->plan;
    const int n_weights = weight_pages(plan),
              n = n_weights + texture_pages(plan, of->own_wavelengths);
    bool done = true;
    for (chunk->page = 0; done && chunk->page < n; chunk->page++) {
        const int texture = chunk->page - n_weights;
        if (texture >= 0 && texture % BANDS_PER_PASS == 0)
            done = load(chunk, texture, err);
        for (int i = 0; done && i < tile->n_chunks; i++) {
            chunk->picture = &tile->chunks[i].picture;
            for (size_t pixel = 0; pixel < picture_pixels(chunk->picture); pixel++)
                chunk->values[pixel] = (float)value_at(chunk, pixel);
            done = of->take(of->context, chunk->picture, chunk->page, chunk->values, err);
        }
    }
    return done;
}

bool decompose(const struct lit_scene *lit, const struct decomposition *of, struct error *err)
{
    const struct rectangle picture = plan_picture(lit->plan);
    struct page_chunk chunk = {.of = of, .lit = lit};
    const bool done =
        MAKE_ARRAY(chunk.values, (size_t)lit->plan->tile_width * (size_t)lit->plan->chunk_rows, err,
                   "the weights of a picture") &&
        tiles_each(lit, &picture, take_tile, &chunk, err);
    free(chunk.values);
    return done;
}
