/* SPDX-License-Identifier: MIT */
/* The room "refine": divides the triangles of a plan where its picture would differ too much from
 * one that lights every point of the true surfaces, and no others. */
#ifndef REFINE_H
#define REFINE_H

#include "data/options/options.h"
#include "raster/accuracy/accuracy.h"
#include "raster/plan/plan.h"
#include "spectral.h"

/* ---- refine.c: from a plan to a finer one ---- */
struct refine_request {
    enum measure_unit unit;
    double error;         /* that 95 % of object pixels may have at most */
    long most_triangles;  /* of all meshes that are refined */
    const char *observer; /* for CIEDE2000 of a scene that is not sampled */
};
struct refined_object {
    int surface;        /* the first of its instances */
    long before, after; /* triangles */
};
struct refine_result {
    struct refine_request wanted;
    struct accuracy_estimate before, after; /* after: empty if nothing was refined */
    struct refined_object *objects;         /* that were refined; owned */
    int n_objects, levels;
    long triangles_before, triangles_after; /* of the plan */
    bool stopped; /* at most_triangles: the error is the least that so many can have, or nearly */
};
/* Refines the plan if the options ask for it; otherwise *out stays zeroed. Divides triangles until
 * 95 % of object pixels have at most the wanted error, or until edges are a twentieth of a pixel
 * long. A triangle that is good enough is divided only where its neighbour is, so that no crack
 * opens; nor does one between objects that meet. Flat shading stays as it is. The caller always
 * frees *out; after an error the plan can only be freed. */
bool refine_options(const struct options *options, struct plan *plan, struct refine_result *out,
                    struct error *err);
void refine_result_free(struct refine_result *result);

/* ---- asked.c: the plan that the command line asks for ---- */
struct asked_plan {
    struct plan plan;
    struct refine_result refined; /* zeroed without --accuracy */
};
/* Plans a scene that scene_read_sampled has read. If --accuracy may choose the wavelengths, it
 * samples the scene: for the colours that the picture shows. Then refines the plan. The caller
 * always frees *out, before the scene and its sampling. */
bool plan_asked(const struct options *options, const struct plan_options *plan_options,
                struct scene *scene, struct sampling *sampling, struct asked_plan *out,
                struct error *err);
void asked_plan_free(struct asked_plan *asked);

/* ---- inside this room ---- */
/* ---- edges.c: a set of edges ---- */
/* An edge is known by the places of its ends in eye space, rounded: two triangles agree on it even
 * where they belong to two objects. */
struct edge_set {
    struct edge_slot {
        uint64_t edge; /* 0: the slot is free */
        float error;
    } * slots;         /* owned */
    size_t n_slots, n; /* n_slots: 0 or a power of two */
};
uint64_t edge_end(struct vector eye);
uint64_t edge_between(uint64_t a, uint64_t b);
/* Adds an edge, or raises its error. */
bool edges_add(struct edge_set *set, uint64_t edge, float error, struct error *err);
bool edges_have(const struct edge_set *set, uint64_t edge);
float edges_error(const struct edge_set *set, uint64_t edge); /* of one that it has */
/* Keeps the edges of the largest errors, `most` or fewer: equal ones stay or go together. */
bool edges_keep_worst(struct edge_set *set, size_t most, struct error *err);
void edges_free(struct edge_set *set);

/* ---- judge.c: which edges of a triangle are too long ---- */
/* The standards by which triangles are judged. */
struct judge {
    const struct plan *plan;
    const struct measure *measure;
    const struct lattice *lattice;
    const struct lattice_pixel *pixels; /* what lies behind them is hidden */
    double error;       /* the largest that is good enough; HUGE_VAL: shading is not judged */
    double shortest_px; /* edges of this length in the window are not divided */
    double outline_px;  /* how far an outline may be from the true one */
};
/* A surface that is judged, its mesh, room for attributes of two points, and edges judged last. */
enum { KNOWN_EDGES = 64 };
struct judged_mesh {
    const struct judged_surface *surface;
    const struct mesh *mesh;
    double *attributes;
    struct known_edge { /* ends: ascending; equal: none */
        int32_t ends[2];
        double error;
    } known[KNOWN_EDGES];
};
/* The errors of a triangle's edges over what is good enough, 0: they may stay; and the largest
 * error of its shading, as far as it was looked for. */
struct judgement {
    float edges[3], shading;
};
void judge_triangle(const struct judge *judge, struct judged_mesh *of, int triangle,
                    struct judgement *out);
/* Returns whether a placed triangle may have to be divided: it reaches the picture, has a long
 * edge, and is not the back of a solid. */
bool judge_concerns(const struct judge *judge, const struct judged_surface *of, int triangle,
                    bool solid);

/* ---- objects.c: the meshes that are refined ---- */
struct refined {        /* the mesh of an object, and of others in the same place */
    int object;         /* the first of them, index in the scene */
    struct shape shape; /* tessellated; shares what the scene's owns */
    struct patches patches;
    struct mesh mesh;
    unsigned char *settled;   /* of each triangle: it is good enough; owned */
    struct judgement *judged; /* of each triangle; of infinite error: it is not judged; owned */
    uint64_t *ends;           /* edge_end of each vertex; owned */
    struct matrix model_view, normal_matrix;
    long before;   /* triangles */
    bool in_front; /* all of it lies beyond the near plane */
};
struct refinement {
    struct plan *plan;
    struct refine_result *result;
    struct measure measure;
    struct judge judge;
    struct refined *list; /* owned */
    int n;
    int *of_object; /* of each object of the scene its index in the list; -1: it stays; owned */
    struct edge_set marked;
    bool changed; /* the last level has divided a triangle */
};
/* Lists the objects in view, or those with round outlines. The caller always frees the list. */
bool objects_list(struct refinement *of, bool round, struct error *err);
void objects_free(struct refinement *of);
void judgements_forget(const struct refined *refined); /* its triangles have to be judged again */
int object_of(const struct plan *plan, int instance);  /* index in the scene */

/* ---- surfaces.c ---- */
/* Lights the vertices of a surface that are wanted; NULL: all. */
void light_vertices(const struct plan *plan, const struct view *view, struct surface *surface,
                    const unsigned char *wanted);
/* Returns the surfaces of all instances in view, placed in the window; NULL after an error. */
struct surface *surfaces_place(const struct plan *plan, struct error *err);
void surfaces_close(struct surface *surfaces, int n);

/* ---- level.c ---- */
/* Divides the triangles that are not settled, and not good enough. */
bool refine_level(struct refinement *of, struct error *err);

#endif
