/* SPDX-License-Identifier: MIT */
/* Pixels that another program drew, as a renderer: a folder with the colours of each pass, and
 * perhaps numbers of triangles and depths. */
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include "raster/beside/verify/inside.h"

const char targets_prefix[] = "targets-";

/* Pixels of another program as a renderer. */
struct drawn {
    struct renderer renderer; /* the first member */
    const struct plan *plan;
    struct foreign_pixels *pixels;
    char path[4096 + 64]; /* of drawn.txt */
    char id[DIGEST_TEXT]; /* that drawn.txt has, and its place there */
    struct place id_place;
    struct driver stated; /* measured before; its name is NULL where drawn.txt does not have it */
    long bits[2];     /* of positions below a pixel, and of depth, as drawn.txt has them; 0: not */
    float *numbers;   /* 4 a pixel; 0, as the background's, where the folder has none; owned */
    uint32_t *depths; /* likewise */
};

static size_t count_pixels(const struct plan *plan)
{
    return (size_t)plan->view.width * (size_t)plan->view.height;
}

/* ---- drawn.txt ---- */

/* Copies the rest of a line, as a driver's name has blanks and may have anything else. */
static void copy_rest(const struct text *text, char *out, size_t capacity)
{
    const char *at = text->at + strspn(text->at, " \t");
    snprintf(out, capacity, "%.*s", (int)(text->line_end - at), at);
    hide_unprintable(out, "");
}

enum drawn_word {
    DRAWN_ID,
    DRAWN_RENDERER,
    DRAWN_VERSION,
    DRAWN_SIZE,
    DRAWN_SUBPIXEL_BITS,
    DRAWN_DEPTH_BITS,
    DRAWN_DRIVER,
    DRAWN_WORDS
};

/* Refuses pixels of another size. */
static bool read_size(struct text *text, const struct word *word, const struct drawn *of,
                      struct error *err)
{
    const struct view *view = &of->plan->view;
    long width, height;
    return text_integer(text, "a number of pixels", 1, INT_MAX, &width, err) &&
           text_integer(text, "a number of pixels", 1, INT_MAX, &height, err) &&
           text_end(text, "size", err) &&
           ((width == view->width && height == view->height) ||
            error_at(err, word->place, "drawn at %ldx%ld, exported at %dx%d", width, height,
                     view->width, view->height));
}

static bool read_line(struct text *text, struct place given[DRAWN_WORDS], struct drawn *out,
                      struct error *err)
{
    static const char *const known[] = {
        "id", "renderer", "version", "size", "subpixel-bits", "depth-bits", "driver", NULL};
    struct renderer_names *names = &out->renderer.names;
    struct word word;
    if (!text_word(text, &word))
        return true;
    const int which = word_choose_once(&word, known, "line of drawn.txt", given, err);
    switch (which) {
    case DRAWN_ID:
        if (!text_expect(text, &word, "the id of scene.txt", err))
            return false;
        snprintf(out->id, sizeof out->id, "%.*s", (int)word.length, word.start);
        out->id_place = word.place;
        return text_end(text, "id", err);
    case DRAWN_RENDERER:
        copy_rest(text, names->renderer, sizeof names->renderer);
        return true;
    case DRAWN_VERSION:
        copy_rest(text, names->version, sizeof names->version);
        return true;
    case DRAWN_SIZE:
        return read_size(text, &word, out, err);
    case DRAWN_SUBPIXEL_BITS:
    case DRAWN_DEPTH_BITS:
        return text_integer(text, "a number of bits", 4, 32,
                            &out->bits[which - DRAWN_SUBPIXEL_BITS], err) &&
               text_end(text, known[which], err);
    case DRAWN_DRIVER:
        return traits_read(text, &out->stated, err);
    default:
        return false;
    }
}

static bool read_words(struct drawn *of, struct error *err)
{
    const struct place whole = {of->path, 0, 0};
    snprintf(of->path, sizeof of->path, "%.4095s/%sdrawn.txt", of->pixels->path,
             of->pixels->prefix);
    struct place given[DRAWN_WORDS] = {{NULL, 0, 0}};
    struct text text;
    if (!text_open(&text, of->path, whole, 0, err))
        return false;
    bool done = true;
    while (done && text_next_line(&text))
        done = read_line(&text, given, of, err);
    of->id_place.path = of->path; /* which outlives that of the text */
    text_free(&text);
    return done &&
           (of->id[0] || error_at(err, whole, "expected a line \"id\" with the id of scene.txt"));
}

/* ---- a folder ---- */

/* Reads a file of the folder, which must have n numbers of 4 bytes a pixel. *found: NULL: it must
 * be there. */
static bool read_numbers(const struct drawn *of, const char *name, size_t n, void *out, bool *found,
                         struct error *err)
{
    const size_t length = count_pixels(of->plan) * n * 4;
    char path[4096 + 2 * FILE_NAME];
    const struct place place = {path, 0, 0};
    const struct builtin_file *builtin;
    struct stat status;
    int descriptor;
    snprintf(path, sizeof path, "%.4095s/%s%s", of->pixels->path, of->pixels->prefix, name);
    if (found && !(*found = stat(path, &status) == 0))
        return errno == ENOENT || error_cause(err, place, "cannot read");
    if (!file_open(path, place, &descriptor, &builtin, err))
        return false;
    bool done = fstat(descriptor, &status) == 0 || error_cause(err, place, "cannot read");
    if (done && (uint64_t)status.st_size != length)
        done = error_at(err, place, "expected a file of %zu bytes, found %lld", length,
                        (long long)status.st_size);
    errno = 0;
    done = done && (read_at(descriptor, out, length, 0) == (ssize_t)length ||
                    error_cause(err, place, "cannot read"));
    close(descriptor);
    return done;
}

/* Refuses the pixels of another scene. */
static bool drawn_take_scene(struct renderer *renderer, const struct lit_scene *lit,
                             struct error *err)
{
    const struct drawn *of = (struct drawn *)renderer;
    char id[DIGEST_TEXT];
    return scene_describe(lit, NULL, "", id, err) &&
           (strcmp(id, of->id) == 0 ||
            error_at(err, of->id_place,
                     "these pixels were drawn of another scene: expected id %s, found %s", id,
                     of->id));
}

/* ---- the renderer ---- */

static bool drawn_draw(struct renderer *renderer, const struct frame_batch *batch,
                       struct error *err)
{
    char name[FILE_NAME];
    snprintf(name, sizeof name, "colours-%d.bin", batch->first_bands[0]);
    return read_numbers((struct drawn *)renderer, name, 4, renderer->buffers[batch->buffers[0]],
                        NULL, err);
}

static struct shown drawn_shown(const struct renderer *renderer, int x, int y)
{
    const struct drawn *of = (const struct drawn *)renderer;
    const size_t at = (size_t)y * (size_t)of->plan->view.width + (size_t)x;
    return shown_of(of->plan->n_instances, of->numbers + 4 * at, of->depths[at]);
}

static void drawn_close(struct renderer *renderer)
{
    struct drawn *of = (struct drawn *)renderer;
    FREE_ALL(of->numbers, of->depths);
    renderer_free(renderer);
}

/* ---- opening ---- */

static bool read_folder(struct drawn *of, struct error *err)
{
    const size_t n = count_pixels(of->plan);
    bool numbers = false, depths = false;
    const bool done = MAKE_ARRAY(of->numbers, 4 * n, err, "numbers.bin") &&
                      MAKE_ARRAY(of->depths, n, err, "depths.bin") && read_words(of, err) &&
                      read_numbers(of, "numbers.bin", 4, of->numbers, &numbers, err) &&
                      read_numbers(of, "depths.bin", 1, of->depths, &depths, err);
    of->renderer.lacks = (struct renderer_lacks){!numbers, !depths};
    return done;
}

/* Finds the driver by which the pixels are judged: one that was measured before, or is by its
 * targets; a known one of that name; one as wide as the bits of drawn.txt say, since OpenGL may cut
 * a position off to its grid, and values run through corners that are moved so. Depth of fewer than
 * 24 bits rounds to a step of its own. Where a known one drew no targets, its program may draw
 * upside down. */
static bool find_driver(const struct drawn *of, struct driver *out, struct error *err)
{
    struct foreign_pixels pixels = {.path = of->pixels->path, .prefix = targets_prefix};
    const struct render_foreign targets = {.open = drawn_open, .of = &pixels};
    char path[sizeof of->path];
    struct stat status;
    *out = *driver_of(of->renderer.names.renderer);
    snprintf(path, sizeof path, "%.4095s/%sdrawn.txt", pixels.path, pixels.prefix);
    if (of->pixels->prefix[0]) /* these are the targets */
        return true;
    if (of->stated.name || stat(path, &status) == 0) {
        if (of->stated.name)
            *out = of->stated;
        else if ((!driver_is_known(out) || plan_has_mipmaps(of->plan)) &&
                 !targets_measure(&targets, NULL, out, err))
            return false;
        of->pixels->driver = *out;
        out->detail.first_row &= of->plan->view.height % 2;
        return true;
    }
    out->detail_error = -1;
    if (driver_is_known(out))
        return true;
    if (of->bits[0] > 0)
        out->grid_px = out->corner_px = ldexp(1, -(int)of->bits[0]);
    if (of->bits[1] > 0)
        out->depth_roundings = fmax(out->depth_roundings, 1.5 * ldexp(1, 24 - (int)of->bits[1]));
    if (of->bits[0] > 0 || of->bits[1] > 0) {
        out->name = "stated by drawn.txt";
        out->is_measured = true;
        out->value_roundings = 160; /* a single operation may be off by 1 in 10^5 */
    }
    return true;
}

bool drawn_open(void *pixels, const struct plan *plan, int n_buffers, struct renderer **out,
                struct error *err)
{
    static const struct renderer_kind kind = {.take_scene = drawn_take_scene,
                                              .draw = drawn_draw,
                                              .shown = drawn_shown,
                                              .close = drawn_close};
    struct drawn *of;
    *out = NULL;
    if (!MAKE_ARRAY(of, 1, err, "the pixels of another program"))
        return false;
    *out = &of->renderer;
    of->renderer.kind = &kind;
    of->renderer.n_at_once = 1;
    of->plan = plan;
    of->pixels = pixels;
    if (plan->tiled)
        return error_usage(err,
                           "the pixels of another program are judged in one piece, of at most "
                           "%d x %d pixels here; choose a smaller --size",
                           plan->tile_width, plan->tile_height);
    if (!renderer_make_buffers(&of->renderer, n_buffers, count_pixels(plan), "the pixels of a pass",
                               err) ||
        !read_folder(of, err))
        return false;
    struct renderer_names *by = &of->renderer.names;
    snprintf(by->library, sizeof by->library, "another program");
    if (!by->renderer[0])
        snprintf(by->renderer, sizeof by->renderer, "an unnamed renderer");
    if (!by->version[0])
        snprintf(by->version, sizeof by->version, "unknown version");
    return find_driver(of, &of->renderer.driver, err);
}
