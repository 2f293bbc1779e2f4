/* SPDX-License-Identifier: MIT */
/* Compares statements of a scene with the thesis's figures and with products of transforms written
 * out by hand, and checks the command line's overrides. test/cases/bad has the scenes and options
 * that are refused; test/raster/reference/effects.py draws lights of all kinds, and shading.py each
 * shading. */

#include "data/maths/maths.h"
#include "data/mesh/mesh.h"
#include "data/sampling/inside.h"
#include "data/scene/inside.h"
#include "data/spectra/spectra.h"
#include "spectral.h"
#include "test.h"

static const char *temporary(const char *name)
{
    static char path[64];
    snprintf(path, sizeof path, "scene/%s", name);
    return path;
}

static const char *write_text(const char *name, const char *content)
{
    return test_write(temporary(name), content);
}

/* Returns the scene. If it cannot be read, the check fails and the scene is empty. */
static struct scene read_scene(const char *name)
{
    struct scene scene;
    struct error err = {0};
    scene_read(name, &scene, &err);
    CHECK_TEXT(err.text, "", "%s is read", name);
    return scene;
}

static struct scene read_string(const char *content)
{
    return read_scene(write_text("string.scene", content));
}

static bool same_vector(struct vector a, double x, double y, double z)
{
    return a.x == x && a.y == y && a.z == z;
}

/* ---- view, size and lights ---- */

static void check_defaults(void)
{
    struct scene s = read_string("# nothing but a light\nlight d65 1 position 0 0 8\n");
    CHECK(s.n_wavelengths == 93 && s.wavelengths_nm[0] == 300 && s.wavelengths_nm[1] == 305 &&
              s.wavelengths_nm[92] == 760,
          "by default there are 93 wavelengths, 300 to 760 nm by 5 nm");
    CHECK(s.width == 1200 && s.height == 800, "by default a picture has 1200 x 800 pixels");
    CHECK(!s.camera.perspective && s.camera.extent == 12 && s.camera.near == -10 &&
              s.camera.far == 10 && same_vector(s.camera.eye, 0, 0, 0) &&
              same_vector(s.camera.look, 0, 0, -1) && same_vector(s.camera.up, 0, 1, 0),
          "by default the view is orthographic along -z, 12 wide and from -10 to 10 deep");
    CHECK(!s.local_viewer && s.shading == SHADING_SMOOTH,
          "by default the viewer is infinite and shading smooth");
    CHECK(s.n_ambients == 0 && s.n_objects == 0 && s.n_materials == 0,
          "by default a scene has nothing else");
    scene_free(&s);
    CHECK(s.path == NULL && s.n_files == 0 && s.wavelengths_nm == NULL, "a freed scene is zeroed");
    s = read_string("camera perspective 60 eye 0 1 0 look 0 0 -10\n");
    CHECK(s.camera.perspective && s.camera.extent == 60 && s.camera.near == 1 &&
              s.camera.far == 64 && same_vector(s.camera.eye, 0, 1, 0) &&
              same_vector(s.camera.look, 0, 0, -10),
          "a perspective view is from 1 to 64 deep");
    scene_free(&s);
}

static void check_view(void)
{
    struct scene s = read_string("viewer local\nshading flat\nsize 262144 1\n"
                                 "camera ortho 2 up 0 0 1 far 7 near -3 look 1 0 0 eye 2 0 0\n"
                                 "ambient a 0.25\nambient 2 0\n");
    CHECK(s.local_viewer && s.shading == SHADING_FLAT, "viewer and shading are read");
    CHECK(s.width == 262144 && s.height == 1, "the widest picture is accepted");
    CHECK(s.camera.near == -3 && s.camera.far == 7 && same_vector(s.camera.up, 0, 0, 1),
          "camera words come in any order");
    CHECK(s.n_ambients == 2 && s.ambients[0].intensity == 0.25 && s.ambients[1].intensity == 0,
          "all ambient lights are listed, even one of intensity 0");
    scene_free(&s);
}

/* ---- wavelengths ---- */

static void check_wavelengths(void)
{
    static const struct {
        const char *text;
        int n;
        double last;
        const char *truth;
    } ranges[] = {
        {"wavelengths 400 700 7\n", 43, 694, "an end between steps is left out"},
        {"wavelengths 400 700 299.9999\n", 2, 699.9999, "an end just after a step is left out"},
        {"wavelengths 555 555 1e300\n", 1, 555, "a range of one wavelength may have any step"},
        {"wavelengths list 400 450.5 1e3 1000000\n", 4, 1e6, "a list may be uneven"},
        {"wavelengths 1 65535 1\n", 65535, 65535, "65535 wavelengths are accepted"}};
    /* 350 / 0.1 is slightly below or above 3500 in binary; the end belongs to the range. */
    struct scene s = read_string("wavelengths 380 730 0.1\n");
    bool near = s.n_wavelengths == 3501;
    for (int i = 0; near && i < 3501; i++)
        near = fabs(s.wavelengths_nm[i] - (3800 + i) / 10.0) <= 0x1p-43; /* 1 unit at 512..1024 */
    CHECK(near, "there are 3501 wavelengths by 0.1 nm, each within one rounding of its decimal");
    scene_free(&s);
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; i++) {
        s = read_string(ranges[i].text);
        CHECK(s.n_wavelengths == ranges[i].n && s.wavelengths_nm[ranges[i].n - 1] == ranges[i].last,
              "%s", ranges[i].truth);
        scene_free(&s);
    }
}

/* ---- objects ---- */

/* The columns, scale and positions before scaling for n objects: rows and scales 1, 0.66, 0.5 and
 * 0.333 are the thesis's, but for those that would leave its view, 12 wide and 8 high. */
static const struct grid {
    int n, columns;
    double scale, first_x, first_y, last_x, last_y;
} grids[] = {
    {1, 1, 1, 0, 0, 0, 0},        {3, 3, 2 / 3.0, -6, 0, 6, 0},   {4, 2, 0.66, -3, 3, 3, -3},
    {8, 4, 0.5, -9, 3, 9, -3},    {9, 3, 4 / 9.0, -6, 6, 6, -6},  {15, 5, 0.4, -12, 6, 12, -6},
    {16, 4, 0.333, -9, 9, 9, -9}, {24, 6, 0.333, -15, 9, 15, -9}, {5, 3, 0.66, -6, 3, 0, -3},
    {30, 8, 0.25, -21, 9, 9, -9},
};

static void check_grid(const struct grid *grid)
{
    char list[2048] = "";
    struct scene s;
    struct vector first, last, corner, one = {1, 1, 1};
    for (int i = 0; i < grid->n; i++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "matt.txt # %d\n", i);
    write_text("matt.txt", "400 0.5\n");
    write_text("grid.list", list);
    s = read_string("checker grid.list plane 1 1 translate 0 0 2 scale 3\n");
    if (CHECK(s.n_objects == grid->n && s.n_materials == 1,
              "%d lines are %d objects; one file is one material", grid->n, grid->n)) {
        first = matrix_point(&s.objects[0].transform, (struct vector){0, 0, 0});
        last = matrix_point(&s.objects[grid->n - 1].transform, (struct vector){0, 0, 0});
        corner = matrix_direction(&s.objects[0].transform, one);
        CHECK(same_vector(first, grid->scale * grid->first_x, grid->scale * grid->first_y,
                          grid->scale * 6),
              "the first of %d objects is at its place", grid->n);
        CHECK(same_vector(last, grid->scale * grid->last_x, grid->scale * grid->last_y,
                          grid->scale * 6),
              "the last of %d objects is at its place", grid->n);
        CHECK_NEAR(corner.x, 3 * grid->scale, 1e-15, "objects are scaled like their distances");
    }
    scene_free(&s);
}

static void check_transforms(void)
{
    struct scene s = read_string("material m { diffuse 0.5 }\n"
                                 "object sphere 1 8 8 material m scale 2 3 4 rotate 90 0 0 5 "
                                 "translate 1 0 0\n"
                                 "object sphere 1 8 8 translate 1 0 0 rotate 90 0 0 1 "
                                 "scale -2 material m\n");
    struct vector p = {1, 1, 1};
    if (CHECK(s.n_objects == 2, "there are two objects")) {
        /* (2,3,4), turned (-3,2,4), moved (-2,2,4) */
        CHECK(same_vector(matrix_point(&s.objects[0].transform, p), -2, 2, 4),
              "transforms apply in the order written");
        /* (2,1,1), turned (-1,2,1), mirrored and doubled (2,-4,-2) */
        CHECK(same_vector(matrix_point(&s.objects[1].transform, p), 2, -4, -2),
              "a single factor scales all axes, and may be negative");
    }
    scene_free(&s);
}

/* Sizes that are left out have defaults; lengths follow the first one. */
static void check_default_sizes(void)
{
    static const double expected[][4] = {{1, 48, 24, 0},        {2, 48, 24, 0}, {2, 2, 2, 1},
                                         {2, 3, 2, 1},          {3, 3, 1, 0},   {0.5, 1, 48, 1},
                                         {0.1, 0.1 * 3, 24, 48}};
    struct scene s = read_string("material m { diffuse 0.5 }\n"
                                 "object sphere material m\nobject sphere 2 material m\n"
                                 "object box 2 material m\nobject box 2 3 material m\n"
                                 "object plane 3 material m\nobject cone 0.5 material m\n"
                                 "object torus 0.1 material m\n");
    for (int i = 0; i < s.n_objects; i++)
        CHECK(memcmp(s.objects[i].shape.parameter, expected[i], sizeof expected[i]) == 0,
              "%s %g, shorter than it may be, has defaults", shape_name(s.objects[i].shape.kind),
              s.objects[i].shape.parameter[0]);
    CHECK(s.n_objects == 7, "sizes may be left out");
    scene_free(&s);
}

static void check_shapes(void)
{
    static const enum shape_kind kinds[] = {SHAPE_SPHERE,   SHAPE_TORUS, SHAPE_BOX,  SHAPE_PLANE,
                                            SHAPE_CYLINDER, SHAPE_CONE,  SHAPE_DISK, SHAPE_TEAPOT};
    struct scene s;
    write_text("room.map", "* material m\n");
    s = read_string("material m { diffuse 0.5 }\n"
                    "object sphere 2.8 3 2 material m\n"
                    "object torus 1 2 3 4096 material m\n"
                    "object box 1 2 3 material m\nobject plane 1 2 material m\n"
                    "object cylinder 1 2 3 1 material m\n"
                    "object cone 1 2 3 1 material m\n"
                    "object disk 1 3 material m\nobject teapot 1 64 material m\n"
                    "object mesh models/cow.obj unitize crease 30 material m\n"
                    "object mesh /room.obj materials room.map\n");
    const struct shape *cow, *room;
    if (CHECK(s.n_objects == 10, "every shape accepts its smallest and largest counts")) {
        for (int i = 0; i < 8; i++)
            CHECK(s.objects[i].shape.kind == kinds[i] && s.objects[i].shape.parameter[0] > 0,
                  "a %s", shape_name(kinds[i]));
        CHECK(s.objects[0].shape.repeat[0] == 1 && s.objects[0].shape.repeat[1] == 1 &&
                  !s.objects[0].shape.planar && !s.objects[0].two_sided,
              "by default a shape is one-sided, and a texture covers its own coordinates once");
        CHECK(s.objects[1].shape.parameter[3] == 4096 && s.objects[0].shape.parameter[0] == 2.8,
              "parameters are in the order written");
        cow = &s.objects[8].shape;
        CHECK(cow->unitize && cow->crease_deg == 30 && cow->place.column == 13 &&
                  strcmp(cow->path, temporary("models/cow.obj")) == 0,
              "a mesh file's path is relative to the scene, and the file is not opened");
        room = &s.objects[9].shape;
        CHECK(!room->unitize && room->crease_deg == 90 && s.objects[9].material == -1 &&
                  strcmp(room->path, "/room.obj") == 0 &&
                  strcmp(s.objects[9].material_map, temporary("room.map")) == 0,
              "a material map stands for a material");
    }
    scene_free(&s);
}

static void check_materials(void)
{
    struct scene s;
    write_text("red.txt", "400 0.25\ng 3\n");
    s = read_string("object sphere 1 8 8 material late\nmaterial \"un used\" none.txt\n"
                    "material late red.txt\nmaterial half { diffuse 1 metamer late }\n"
                    "object sphere 1 8 8 material late\nobject sphere 1 8 8 material half\n");
    if (CHECK(s.n_materials == 3, "an unused file need not exist")) {
        CHECK(s.objects[0].material == 1 && s.objects[1].material == 1 &&
                  s.objects[2].material == 2,
              "a material may be used before it is defined");
        CHECK(strcmp(s.materials[1].name, "late") == 0 && s.materials[1].gloss == 3,
              "a file's material has the scene's name");
        CHECK(s.materials[0].diffuse.kind == SPECTRUM_NONE &&
                  strcmp(s.materials[0].path, temporary("none.txt")) == 0,
              "an unused material keeps only name and path");
    }
    scene_free(&s);
    s = read_string("material a { diffuse 1 metamer b }\nmaterial b red.txt\n"
                    "material c { diffuse 1 metamer missing }\nobject plane 1 1 material a\n");
    CHECK(s.n_materials == 3 && s.materials[1].diffuse.count == 1,
          "a partner is read, and must exist, only if a used material names it");
    CHECK(s.materials[0].partner_index == 1, "the partner is found");
    scene_free(&s);
}

static void check_object_words(void)
{
    struct scene s = read_string("material m { diffuse 0.5 }\n"
                                 "object plane 1 1 two-sided repeat 2.5 1e-3 material m planar\n");
    write_text("matt.txt", "400 0.5\n");
    write_text("two.list", "matt.txt\nmatt.txt\n");
    if (CHECK(s.n_objects == 1, "words of an object come in any order"))
        CHECK(s.objects[0].two_sided && s.objects[0].shape.planar &&
                  s.objects[0].shape.repeat[0] == 2.5 && s.objects[0].shape.repeat[1] == 1e-3,
              "two-sided, planar and repeat apply to any shape");
    scene_free(&s);
    s = read_string("checker two.list plane 1 1 repeat 3 4 two-sided\n");
    CHECK(s.n_objects == 2 && s.objects[1].shape.repeat[1] == 4 && s.objects[1].two_sided,
          "two-sided and repeat apply to each object of a checker");
    scene_free(&s);
}

/* ---- materials of parts ---- */

static const struct material *used(const struct scene *s, int object, int use)
{
    return &s->materials[s->objects[object].assignments[use].material];
}

static void check_map(void)
{
    struct scene s;
    write_text("red.txt", "400 0.25\n");
    write_text("one.list", "red.txt\n");
    mkdir(temporary("maps"), 0777);
    write_text("maps/a.mtl", "newmtl wall\nKd 0.5 0.5 0.5\n");
    write_text("maps/room.map", "# a room\nwall mtl a.mtl\n\n  \"\" material late # none\n"
                                "\"two words\" material half\n* material wall\n");
    s = read_string("material wall { diffuse 0.125 }\n"
                    "object mesh room.obj materials maps/room.map\n"
                    "material half { diffuse 1 metamer other }\nmaterial other red.txt\n"
                    "material late red.txt\nmaterial unused none.txt\n"
                    "object mesh room.obj materials maps/room.map unitize\n"
                    "checker one.list plane 1 1\n");
    if (CHECK(s.n_objects == 3 && s.objects[0].n_assignments == 4 &&
                  s.objects[1].n_assignments == 4,
              "a map names materials of the scene and entries of MTL files")) {
        CHECK_TEXT(s.objects[0].assignments[0].name, "wall",
                   "a map's line begins with a name from usemtl");
        CHECK_TEXT(s.objects[0].assignments[1].name, "", "\"\" stands for faces without a name");
        CHECK_TEXT(s.objects[0].assignments[2].name, "two words", "a name may be quoted");
        CHECK_TEXT(s.objects[0].assignments[3].name, "*", "* stands for all other names");
        CHECK(s.objects[0].assignments[1].place.line == 4 &&
                  s.objects[0].assignments[1].place.column == 3,
              "each line keeps its source place in the map");
        CHECK(used(&s, 0, 0)->from_rgb && used(&s, 0, 0)->diffuse.value[0] == 0.5 &&
                  strcmp(used(&s, 0, 0)->path, temporary("maps/a.mtl")) == 0,
              "an MTL file's path is relative to the map");
        CHECK(used(&s, 0, 1)->diffuse.count == 1,
              "materials are read even if they are defined later");
        CHECK(!used(&s, 0, 3)->from_rgb && used(&s, 0, 3)->diffuse.parameter[0] == 0.125,
              "a material of the scene is not confused with an MTL entry of the same name");
        CHECK(used(&s, 0, 0) == used(&s, 1, 0), "two uses of one entry share a material");
        CHECK(s.materials[used(&s, 0, 2)->partner_index].diffuse.count == 1,
              "partners are found and read");
    }
    scene_free(&s);
}

static struct scene read_entry(const char *entry)
{
    char mtl[1024];
    snprintf(mtl, sizeof mtl, "Kd no number\nnewmtl other\nKd wrong\nnewmtl x # here\n%snewmtl y\n",
             entry);
    write_text("one.mtl", mtl);
    write_text("one.map", "x mtl one.mtl\n");
    return read_string("object mesh x.obj materials one.map\n");
}

static void check_mtl(void)
{
    static const struct {
        double nm, value;
    } spread[] = {{1e-3, 0.2}, {300, 0.2}, {480, 0.2}, {490, 0.4}, {500, 0.6},
                  {570, 0.6},  {585, 0.8}, {600, 1},   {780, 1},   {1e6, 1}};
    struct scene s = read_entry("Ka 1 1\nKd 1 .6 .2\nillum 2\nKs 0.5 0.5 0.5\nNs 1000\n"
                                "map_Kd wood.png\nd 1.0\nKe 3 3 3\nKrzl\n");
    const struct material *m = s.materials;
    if (CHECK(s.n_materials == 1, "only the named entry is read")) {
        CHECK_TEXT(m->name, "x", "its name is the name in the map");
        CHECK(m->from_rgb && m->place.line == 4 && m->place.column == 8 &&
                  strcmp(m->place.path, temporary("one.mtl")) == 0,
              "its source place is the entry's name");
        for (size_t i = 0; i < sizeof spread / sizeof spread[0]; i++)
            CHECK_NEAR(spectrum_at(&m->diffuse, spread[i].nm, SPECTRUM_HOLD), spread[i].value,
                       1e-15, "red, green and blue have the right value at %g nm", spread[i].nm);
        CHECK(m->gloss == 128, "Ns is limited to 128");
        for (int nm = 300; nm <= 760; nm++)
            if (spectrum_at(&m->specular, nm, SPECTRUM_HOLD) != 0.5 ||
                spectrum_at(&m->glow, nm, SPECTRUM_ZERO) != 3)
                CHECK(false, "a grey is constant, also at %d nm", nm);
        CHECK(m->specular.kind == SPECTRUM_SAMPLED && m->glow.kind == SPECTRUM_SAMPLED,
              "Ks with Ns becomes specular, and Ke emission");
    }
    scene_free(&s);
    s = read_entry("Kd 0 0 0\nKs 0 0 0\nNs 20\nKe 0 0 0\n");
    CHECK(s.n_materials == 1 && s.materials[0].diffuse.kind == SPECTRUM_SAMPLED &&
              s.materials[0].specular.kind == SPECTRUM_NONE && s.materials[0].gloss == 0 &&
              s.materials[0].glow.kind == SPECTRUM_NONE,
          "black highlights and black emission are absent, but diffuse is always present");
    scene_free(&s);
    s = read_entry("Ks 0.5 0.5 0.5\nKe 1 0 0\nNs 0\n");
    CHECK(s.n_materials == 1 && s.materials[0].specular.kind == SPECTRUM_NONE &&
              spectrum_at(&s.materials[0].diffuse, 600, SPECTRUM_HOLD) == 0 &&
              spectrum_at(&s.materials[0].glow, 650, SPECTRUM_ZERO) == 1 &&
              spectrum_at(&s.materials[0].glow, 550, SPECTRUM_ZERO) == 0,
          "without Kd diffuse is 0, and without Ns nothing is specular");
    scene_free(&s);
}

/* ---- files ---- */

static void check_includes(void)
{
    struct scene s;
    write_text("lights.scene", "light 1 1 position 0 0 8\nlight 1 2 position 0 -6 8\n");
    s = read_string("include lights.scene\nsize 10 20\ninclude \"lights.scene\"\n");
    CHECK(s.n_lights == 4 && s.lights[3].intensity == 2 && s.width == 10,
          "a file may be included twice");
    CHECK(s.n_lights == 4 && strcmp(s.lights[1].place.path, temporary("lights.scene")) == 0 &&
              s.lights[1].place.line == 2,
          "a light keeps the file and line that defined it");
    scene_free(&s);
}

static void check_thesis_scene(void)
{
    struct scene s = read_scene("colorchecker"), list;
    const double *torus;
    struct vector at;
    if (CHECK(s.n_objects == 25 && s.n_materials == 25, "the scene has 24 tori and a background")) {
        CHECK(s.n_lights == 2 && same_vector(s.lights[0].position, 0, 0, 8) &&
                  s.lights[1].intensity == 0 && s.lights[0].intensity == 1 && s.n_ambients == 1 &&
                  s.ambients[0].intensity == 0.1,
              "the scene has the thesis's light and a little ambient light");
        at = matrix_point(&s.objects[0].transform, (struct vector){0, 0, 0});
        CHECK(s.objects[0].shape.parameter[0] == 14 && s.objects[0].shape.parameter[1] == 40 &&
                  same_vector(at, 0, 0, -16),
              "the background is a sphere of radius 14 at z = -16");
        CHECK(spectrum_at(&s.materials[s.objects[0].material].diffuse, 500, SPECTRUM_HOLD) == 0.2,
              "the background's reflectance is 0.2");
        torus = s.objects[24].shape.parameter;
        CHECK(torus[0] == 1.05 && torus[1] == 1.65 && torus[2] == 30 && torus[3] == 30 &&
                  strcmp(s.materials[s.objects[24].material].name, "24-black") == 0,
              "the last torus is the black patch");
    }
    list = read_scene("builtin:materials/colorchecker.list");
    CHECK(list.n_objects == s.n_objects && list.n_objects == 25 &&
              memcmp(&list.objects[24].transform, &s.objects[24].transform,
                     sizeof list.objects[24].transform) == 0 &&
              strcmp(list.path, "builtin:materials/colorchecker.list") == 0,
          "a list of materials is shown in the same scene");
    scene_free(&list);
    write_text("one.list", "\n# the only one\nred.txt\n");
    list = read_scene(temporary("one.list"));
    CHECK(list.n_objects == 2 && strcmp(list.materials[list.objects[1].material].name, "red") == 0,
          "a list may have one material");
    scene_free(&list);
    scene_free(&s);
}

/* ---- the command line ---- */

static void check_overrides(void)
{
    struct error err = {0};
    struct scene s = read_string("light d65*3 2 position 0 0 8\nambient 1 1\nambient 1 1\n");
    test_write("lamp.csv", "400,1\n700,2\n");
    CHECK(scene_set_light(&s, "1=a", &err) && s.lights[0].intensity == 2 &&
              strcmp(s.lights[0].spectrum.name, "a") == 0,
          "a spectrum alone keeps the intensity");
    CHECK(scene_set_light(&s, "1=d65*0.5", &err) && s.lights[0].intensity == 0.5 &&
              s.lights[0].spectrum.factor == 1,
          "*INTENSITY sets the intensity, and is no factor of the spectrum");
    CHECK(scene_set_light(&s, "1=lamp.csv*2", &err) && s.lights[0].intensity == 2 &&
              s.lights[0].spectrum.place.column == 3,
          "a file's path is relative to the current folder");
    CHECK(scene_set_ambient(&s, "d65", &err) && s.n_ambients == 1 && s.ambients[0].intensity == 1,
          "--ambient replaces all ambient lights, with intensity 1");
    CHECK(scene_set_ambient(&s, "d65*0.1", &err) && s.ambients[0].intensity == 0.1 &&
              s.ambients[0].spectrum.factor == 1,
          "--ambient may give an intensity");
    CHECK(scene_set_shading(&s, "phong", &err) && s.shading == SHADING_PHONG &&
              scene_set_tessellation(&s, "2", &err),
          "shading and tessellation are set");
    CHECK_TEXT(err.text, "", "no override failed");
    scene_free(&s);
}

/* Multiplies the counts of shapes by a factor: lengths stay, and counts are as expected. */
static void check_tessellation(void)
{
    static const struct {
        enum shape_kind kind;
        double from[4], factor, expected[4];
    } all[] = {
        {SHAPE_SPHERE, {1.5, 40, 20, 0}, 2, {1.5, 80, 40, 0}},
        {SHAPE_SPHERE, {1.5, 5, 5, 0}, 0.5, {1.5, 3, 3, 0}},
        {SHAPE_SPHERE, {1.5, 40, 20, 0}, 1e-300, {1.5, 3, 2, 0}},
        {SHAPE_SPHERE, {1.5, 40, 20, 0}, 1e308, {1.5, 4096, 4096, 0}},
        {SHAPE_TORUS, {1, 2, 10, 30}, 1.26, {1, 2, 13, 38}},
        {SHAPE_TORUS, {1, 2, 10, 30}, 0.1, {1, 2, 3, 3}},
        {SHAPE_BOX, {1, 2, 3, 2}, 7, {1, 2, 3, 14}},
        {SHAPE_PLANE, {1, 2, 3, 0}, 0.1, {1, 2, 1, 0}},
        {SHAPE_CYLINDER, {1, 2, 10, 3}, 0.1, {1, 2, 3, 1}},
        {SHAPE_CONE, {1, 2, 10, 3}, 3, {1, 2, 30, 9}},
        {SHAPE_DISK, {1, 12, 1, 0}, 1.04, {1, 12, 1, 0}},
        {SHAPE_TEAPOT, {1, 10, 0, 0}, 7, {1, 64, 0, 0}},
        {SHAPE_MESH, {0, 0, 0, 0}, 7, {0, 0, 0, 0}},
    };
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        const double *from = all[i].from, *expected = all[i].expected;
        struct shape shape = {.kind = all[i].kind};
        memcpy(shape.parameter, from, sizeof shape.parameter);
        shape = shape_tessellated(&shape, all[i].factor);
        CHECK(shape.kind == all[i].kind &&
                  memcmp(shape.parameter, expected, sizeof shape.parameter) == 0,
              "%s of %g %g %g %g times %g has %g %g %g %g", shape_name(all[i].kind), from[0],
              from[1], from[2], from[3], all[i].factor, expected[0], expected[1], expected[2],
              expected[3]);
    }
}

/* Returns whether all values of the row are `factor`. */
static bool is_constant(const double *row, int n, double factor)
{
    bool same = true;
    for (int i = 0; i < n; i++)
        same = same && row[i] == factor;
    return same;
}

/* Light 1 has the spectrum of light 2, light 4 does not shine; the mesh and the textures that the
 * scene names do not exist. `half` belongs to a map's object, `unused` to no object. */
static const char spectral_scene[] =
    "wavelengths list 400 450.5 500.2\n"
    "light 2 3 position 0 0 9\n"
    "light 2 1 position 9 0 9\n"
    "light gaussian:450,10 1 position 0 0 9\n"
    "light 1 0 position 0 0 9\n"
    "ambient 0.5 1\n"
    "material plain { diffuse 0.5 texture none.tif }\n"
    "material glossy { diffuse 0.25 gloss 9 emission 4 spectral-texture none.tif }\n"
    "material half { diffuse 0.125 metamer plain }\n"
    "material unused { diffuse 0.375 }\n"
    "object sphere 1 9 9 material plain\n"
    "object mesh none.obj materials spectral.map\n";

static void check_spectra(void)
{
    struct fine_spectra spectra;
    struct error err = {.status = EXIT_AGREED};
    write_text("spectral.map", "a material glossy\nb material half\n");
    struct scene s = read_string(spectral_scene);
    bool done = scene_spectra(&s, &spectra, &err);
    CHECK_TEXT(err.text, "", "spectra of a scene are computed without its mesh and its textures");
    if (!done)
        return;
    const int n = spectra.n_nm;
    CHECK(spectra.first_nm == 400 && n == 101,
          "spectra have a value at every nm from the first wavelength on");
    CHECK(spectra.n_lights == 4, "the lights are two, then the ambient light and the emission (%d)",
          spectra.n_lights);
    CHECK(is_constant(spectra.lights, n, 6), "lights with the same spectrum are added");
    CHECK(spectra.lights[n + 50] == 1,
          "a light with another spectrum is separate, here at its peak");
    CHECK(is_constant(spectra.lights + 2 * n, n, 0.5), "the ambient light is constant");
    CHECK(is_constant(spectra.lights + 3 * n, n, 4), "the emission is constant");
    CHECK(spectra.n_products == 3 + 5 + 3,
          "matt materials have three products, glossy ones five, unused ones none (%d)",
          spectra.n_products);
    CHECK(is_constant(spectra.products, n, 0.25), "a product is ambient light x reflectance");
    CHECK(is_constant(spectra.products + n, n, 3), "a product is light x reflectance");
    CHECK(is_constant(spectra.products + 3 * n, n, 4.125),
          "a product is ambient light x reflectance + emission");
    CHECK(is_constant(spectra.products + 5 * n, n, 6), "a product is light x specular reflectance");
    CHECK(is_constant(spectra.products + 9 * n, n, 0.75),
          "a part of an object has its own products");
    fine_spectra_free(&spectra);
    scene_free(&s);
    s = read_string("wavelengths list 400 66000\n");
    CHECK(!scene_spectra(&s, &spectra, &err) && err.status == EXIT_INPUT &&
              strstr(err.text, ":1:1: error: wavelengths from 400 to 66000 nm") != NULL,
          "a range that is too long is refused (%s)", err.text);
    scene_free(&s);
}

int main(void)
{
    test_enter();
    mkdir("scene", 0777);
    check_defaults();
    check_view();
    check_wavelengths();
    for (size_t i = 0; i < sizeof grids / sizeof grids[0]; i++)
        check_grid(&grids[i]);
    check_transforms();
    check_shapes();
    check_default_sizes();
    check_materials();
    check_object_words();
    check_map();
    check_mtl();
    check_includes();
    check_thesis_scene();
    check_overrides();
    check_tessellation();
    check_spectra();
    return test_end();
}
