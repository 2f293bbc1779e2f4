/* SPDX-License-Identifier: MIT */
/* The room "parts": a picture that any number of processes draw, each a part of it, and put
 * together to the bytes of one process. A part is a list of tiles. Its file grows by one complete
 * tile after the other, so that a process that is killed loses one tile, and the next one goes on
 * behind the last complete tile. All bytes of the file follow from the scene, the options and the
 * part: two processes that write the same file write the same bytes. */
#ifndef PARTS_H
#define PARTS_H

#include "data/digest/digest.h"
#include "data/record/record.h"
#include "data/unfinished/unfinished.h"
#include "raster/deal/deal.h"
#include "raster/plan/plan.h"
#include "raster/renderer/renderer.h"
#include "raster/stages/stages.h"
#include "raster/verdict/verdict.h"
#include "spectral.h"

/* ---- facts.c: what all parts of a picture have in common ---- */

struct part_facts {
    double full_scale, unchecked;
    bool clips, check, strict, measured; /* measured: the driver's bounds */
    bool shared;                         /* samples are in the unfinished stack, not in the parts */
    struct renderer_names names;         /* empty: OpenGL does not draw */
    struct renderer_lacks lacks;
};
/* Writes facts and record as lines "KEY: VALUE". Allocated; NULL: no memory. */
char *facts_text(const struct plan *plan, const struct part_facts *facts, const char *record);
/* Returns false where this is no such text. */
bool facts_read(const char *text, struct part_facts *out);
/* Finds the first line in which two such texts differ, of each text; "" where it has none. Returns
 * false where they are the same. */
enum { FACT_LINE = 160 };
bool facts_differ(const char *a, const char *b, char line_a[FACT_LINE], char line_b[FACT_LINE]);

/* ---- file.c: the file of a part ---- */

enum { MARK_BYTES = 32, MOST_LATE = 64 };
struct part_file {
    struct tile_sink sink; /* the first member: appends tiles */
    const struct plan *plan;
    struct picture_part part;
    char *path, *text;          /* text: the facts; owned */
    struct output output;       /* its path is the one above; descriptor -1: none is open */
    struct stack_writer *stack; /* takes the samples; NULL: the part's own file does */
    int *tiles;                 /* of the part; owned */
    int n_tiles, n_complete;
    uint64_t at; /* where the next tile begins */
    /* of the tile that is being written: bytes of samples so far, and their checksum */
    uint64_t length;
    uint32_t checksum;
    /* the last tiles: their samples may not be on the disk yet, so that they have no mark */
    struct part_mark {
        uint64_t at;
        unsigned char bytes[MARK_BYTES];
    } late[MOST_LATE];
    int n_late;
    double synced; /* clock_seconds when all was on the disk */
};
/* A complete tile: where its samples lie in the file, if they do, those of the object map before
 * the pages; and its sums.
 */
struct part_tile {
    uint64_t samples;
    uint32_t checksum; /* of the samples */
    unsigned char *sums;
    size_t sums_length; /* owned */
};
/* Returns the name of a part's file, which lies beside the stack. Allocated; NULL: no memory. */
char *part_name(const char *stack, const struct picture_part *part);
/* Opens the file of a part to go on with it, or makes it: file->part is set, and file->stack if the
 * unfinished stack takes the samples. Refuses a file that records other facts, and a full disk. The
 * caller reads all complete tiles before it writes others, and closes the file, also after a
 * failure. text: the facts, copied. */
bool part_create(const char *stack, const struct plan *plan, const char *text,
                 struct part_file *file, struct error *err);
bool part_begun(const struct part_file *file); /* it has a complete tile */
/* Opens the file to read it, and reads its facts. part_plan lists its tiles, which come next. */
bool part_open(const char *path, const struct picture_part *part, struct part_file *out,
               struct error *err);
bool part_plan(struct part_file *file, const struct plan *plan, struct error *err);
/* Reads the next complete tile, which counts as complete from then on. *found: there is one. */
bool part_next(struct part_file *file, bool *found, struct part_tile *out, struct error *err);
/* Reads samples from byte `at` of a file, and adds them to their checksum. */
bool part_samples(const struct part_file *file, uint64_t at, void *out, size_t length,
                  uint32_t *checksum, struct error *err);
void part_close(struct part_file *file); /* a zeroed one is fine */

/* ---- find.c: the parts of a stack ---- */

/* Finds the files of all parts beside a stack, and opens them. Refuses a missing part, files of
 * different counts, and parts that record different facts. The caller frees *out, also after a
 * failure. */
struct parts {
    struct part_file *list; /* owned */
    int n;
};
bool parts_find(const char *stack, struct parts *out, struct error *err);
void parts_free(struct parts *parts);

/* ---- collect.c: complete tiles ---- */

struct collector {
    const struct plan *plan;
    struct stack_writer *writer; /* gets the samples, or has them; NULL: they are not read */
    struct tile_sums own, *picture;
    unsigned char *samples; /* of a page of a tile; owned */
};
/* Adds sums to those of the picture, whose totals are open if there is a check. The caller closes
 * *out, also after a failure. */
bool collector_open(const struct plan *plan, struct stack_writer *writer, struct tile_sums *picture,
                    struct collector *out, struct error *err);
/* Takes the next complete tile of a part; *found: there is one. Refuses samples that differ from
 * their checksum. */
bool collector_take(struct collector *collector, struct part_file *file, bool *found,
                    struct error *err);
void collector_close(struct collector *collector);
/* Takes all tiles of a picture. Refuses a part that is not complete. */
bool parts_collect(struct parts *parts, const struct plan *plan, struct stack_writer *writer,
                   struct tile_sums *picture, struct error *err);

#endif
