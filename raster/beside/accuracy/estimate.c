/* SPDX-License-Identifier: MIT */
/* The error of a picture's shading, from a lattice of its pixels. */
#include "raster/beside/accuracy/inside.h"

/* ---- some pixels ---- */

/* Finds the triangles that the picture shows at a lattice of its pixels. A triangle is scanned in
 * coordinates in which the lattice is made of whole pixels: one that lies between its pixels costs
 * next to nothing. */

/* A lattice of pixels: each has the same share of the picture, and no row or column has many. */
struct lattice {
    int step, shear, rows, columns; /* pixel (i, j): x = step i + shear j, y = step j */
};
struct lattice_pixel {
    double depth;
    int32_t surface;                 /* -1: background */
    struct screen_triangle triangle; /* that is seen */
    double at[2];                    /* the pixel's centre in the picture */
};
struct judged_point {
    int surface;
    const struct object *object;
    float error;
    bool is_fine; /* on a triangle smaller than a pixel, of a shape that fewer would draw */
};
struct estimating {
    const struct lit_scene *lit;
    struct measure measure;
    struct lattice lattice;
    struct lattice_pixel *pixels; /* [row][column] that the reference shows; owned */
    int n_pixels;
    struct patches *patches;     /* of each mesh of the plan; owned */
    struct judged_point *points; /* those that are judged; owned */
    int n_points;
    double *attributes; /* room that compare_point needs; owned */
};

/* Returns the lattice. The step is odd and the shear even, so that the places are pixel centres;
 * the shear is near the step over the golden ratio, so that rows of pixels do not repeat soon. */
static struct lattice lattice_of(const struct view *view, int wanted)
{
    const double pixels = (double)view->width * view->height;
    const int step = 2 * (int)(sqrt(pixels / wanted) / 2) + 1;
    return (struct lattice){.step = step,
                            .shear = step > 1 ? 2 * (int)(0.309 * step + 0.5) : 0,
                            .rows = (view->height + step - 1) / step,
                            .columns = (view->width + step - 1) / step + 2};
}

/* The column of the lattice that holds the first place of a row inside the picture, or the one
 * before. */
static int first_column(const struct lattice *lattice, int row)
{
    return (int)floor(-(double)lattice->shear * (row + 0.5) / lattice->step - 0.5);
}

/* A triangle that is scanned. */
struct lattice_scan {
    const struct estimating *of;
    int surface;
    const struct screen_triangle *triangle;
};

/* Draws a pixel that the triangle covers, if it lies inside the picture. x, y: column and row of
 * the lattice. Keeps the first of fragments that are equally deep. */
static bool draw_pixel(void *context, int x, int y)
{
    const struct lattice_scan *scan = context;
    const struct lattice *lattice = &scan->of->lattice;
    const struct view *view = &scan->of->lit->plan->view;
    const double at[2] = {lattice->step * (x + 0.5) + lattice->shear * (y + 0.5),
                          lattice->step * (y + 0.5)};
    const double depth = covered_depth(scan->triangle, at[0], at[1]);
    struct lattice_pixel *pixel =
        &scan->of->pixels[y * lattice->columns + x - first_column(lattice, y)];
    if (at[0] > 0 && at[0] < view->width && at[1] < view->height && depth >= 0 &&
        depth < pixel->depth)
        *pixel = (struct lattice_pixel){depth, scan->surface, *scan->triangle, {at[0], at[1]}};
    return true;
}

static void draw_triangle(const struct estimating *of, int surface,
                          const struct screen_triangle *triangle)
{
    struct lattice_scan scan = {of, surface, triangle};
    const struct lattice *lattice = &of->lattice;
    struct screen_triangle sheared = *triangle;
    for (int i = 0; i < 3; i++) {
        sheared.y[i] = triangle->y[i] / lattice->step;
        sheared.x[i] = (triangle->x[i] - lattice->shear * sheared.y[i]) / lattice->step;
    }
    const double end = fmin(lattice->rows, most_of(sheared.y) + 1);
    /* by rows: a rectangle around several, sheared, is mostly beside the picture */
    for (int row = (int)fmax(0, least_of(sheared.y) - 1); row < end; row++) {
        const struct rectangle at = {first_column(lattice, row), row, lattice->columns, 1};
        scan_triangle(&sheared, &at, 0, draw_pixel, &scan);
    }
}

static void draw_surface(const struct estimating *of, int index)
{
    struct screen_triangle parts[SCREEN_TRIANGLES];
    const struct surface *surface = &of->lit->surfaces[index];
    for (int i = 0; i < surface->instance->n_triangles; i++) {
        const int n = screen_triangles(&of->lit->plan->view, surface, i, depth_planes, 2, parts);
        for (int part = 0; part < n; part++)
            draw_triangle(of, index, &parts[part]);
    }
}

/* Looks at about `wanted` pixels of the picture. Of the surfaces only the window matters. */
static bool find_seen(struct estimating *of, int wanted, struct error *err)
{
    of->lattice = lattice_of(&of->lit->plan->view, wanted);
    of->n_pixels = of->lattice.rows * of->lattice.columns;
    if (!MAKE_ARRAY(of->pixels, (size_t)of->n_pixels + 1, err, "the pixels that are judged"))
        return false;
    for (int i = 0; i < of->n_pixels; i++)
        of->pixels[i] = (struct lattice_pixel){.depth = 1, .surface = -1};
    for (int s = 0; s < of->lit->plan->n_instances; s++)
        if (of->lit->plan->instances[s].in_view && !of->lit->plan->instances[s].twin)
            draw_surface(of, s);
    return true;
}

/* ---- points ---- */

/* Judges a pixel of the lattice, unless it shows the background or does not see the true surface.
 */
static void judge_pixel(struct estimating *of, const struct lattice_pixel *pixel)
{
    struct shaded_point points[2];
    if (pixel->surface < 0)
        return;
    const struct placed_instance *placed = &of->lit->plan->instances[pixel->surface];
    const struct judged_surface surface = {of->lit, placed, &of->lit->plan->meshes[placed->mesh],
                                           &of->lit->surfaces[pixel->surface],
                                           &of->patches[placed->mesh]};
    if (compare_point(&surface, &pixel->triangle, pixel->at, of->attributes, points))
        of->points[of->n_points++] = (struct judged_point){
            pixel->surface, placed->object,
            (float)measure_difference(&of->measure, placed->shaded, &points[0], &points[1]),
            surface.mesh->mesh.parametric && pixel->triangle.twice_area < 2};
}

/* Opens the patches of all shapes. */
static bool open_patches(struct estimating *of, struct error *err)
{
    bool done = true;
    for (int i = 0; done && i < of->lit->plan->n_meshes; i++)
        if (of->lit->plan->meshes[i].mesh.parametric)
            done = patches_open(&of->lit->plan->meshes[i].shape, &of->patches[i], err);
    return done;
}

/* ---- conclusions ---- */

static int by_error(const void *a, const void *b)
{
    const float one = ((const struct judged_point *)a)->error,
                two = ((const struct judged_point *)b)->error;
    return (one > two) - (one < two);
}

static int by_object(const void *a, const void *b)
{
    const struct judged_point *one = a, *two = b;
    return one->object != two->object ? (one->object > two->object) - (one->object < two->object)
                                      : by_error(a, b);
}

static int worst_first(const void *a, const void *b)
{
    const struct accuracy_object *one = a, *two = b;
    return one->quantile_95 != two->quantile_95
               ? (one->quantile_95 < two->quantile_95) - (one->quantile_95 > two->quantile_95)
               : (one->surface > two->surface) - (one->surface < two->surface);
}

/* Returns the error that 95 % of n points, sorted, have at most. */
static double quantile(const struct judged_point *points, int n)
{
    return n > 0 ? (double)points[n - n / 20 - 1].error : 0;
}

/* Judges the pixels, and sums up: of all, and of each object, which its first instance stands for.
 */
static bool conclude(struct estimating *of, struct accuracy_estimate *out, struct error *err)
{
    const size_t size = sizeof *of->points;
    for (int i = 0; i < of->n_pixels; i++)
        judge_pixel(of, &of->pixels[i]);
    qsort(of->points, (size_t)of->n_points, size, by_error);
    out->quantile_95 = quantile(of->points, of->n_points);
    out->n_points = of->n_points;
    qsort(of->points, (size_t)of->n_points, size, by_object);
    for (int i = 0, n; i < of->n_points; i += n) {
        const struct judged_point *points = &of->points[i];
        struct accuracy_object object = {.surface = points->surface};
        for (n = 0; i + n < of->n_points && points[n].object == points->object; n++) {
            object.n_fine += points[n].is_fine;
            if (points[n].surface < object.surface)
                object.surface = points[n].surface;
        }
        object.quantile_95 = quantile(points, n);
        object.points = n;
        if (!array_add(&out->objects, &out->n_objects, &object, sizeof object, err))
            return false;
    }
    if (out->n_objects > 0)
        qsort(out->objects, (size_t)out->n_objects, sizeof *out->objects, worst_first);
    return true;
}

/* ---- all of it ---- */

bool accuracy_estimate(const struct lit_scene *lit, const char *observer, int wanted,
                       struct accuracy_estimate *out, struct error *err)
{
    const struct plan *plan = lit->plan;
    struct estimating of = {.lit = lit};
    bool done = measure_make(lit, out->unit, observer, &of.measure, err);
    free(out->objects);
    *out = (struct accuracy_estimate){.known = of.measure.known, .unit = of.measure.unit};
    if (done && of.measure.known && lit->surfaces)
        done =
            find_seen(&of, wanted, err) &&
            MAKE_ARRAY(of.patches, (size_t)plan->n_meshes + 1, err, "the shapes that are judged") &&
            MAKE_ARRAY(of.points, (size_t)of.n_pixels + 1, err, "the pixels that are judged") &&
            MAKE_ARRAY(of.attributes, 2 * (plan->max_rows + 2), err, "a pixel that is judged") &&
            open_patches(&of, err) && conclude(&of, out, err);
    for (int i = 0; of.patches && i < plan->n_meshes; i++)
        patches_close(&of.patches[i]);
    FREE_ALL(of.patches, of.points, of.pixels, of.attributes, of.measure.xyz);
    return done;
}
