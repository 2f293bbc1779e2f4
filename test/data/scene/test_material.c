/* SPDX-License-Identifier: MIT */
/* Material files of the thesis's format, and materials in a scene, are accepted and mean what their
 * authors expect. test/cases/bad has those that are refused. */

#include "data/scene/inside.h"
#include "data/spectra/spectra.h"
#include "data/text/text.h"
#include "spectral.h"
#include "test.h"

/* Returns a material without a diffuse spectrum after an error. */
static struct material read_file(const char *path, struct error *err)
{
    struct material out;
    struct place nowhere = {0};
    *err = (struct error){0};
    material_read(path, nowhere, &out, err);
    return out;
}

static struct material read_words(const char *words, struct text *rest, struct error *err)
{
    struct material out;
    *err = (struct error){0};
    text_open_string(rest, "scenes/t.scene", words, err);
    text_next_line(rest);
    material_read_words(rest, &out, err);
    return out;
}

static void check_matt_file(void)
{
    struct error err;
    struct material m = read_file(test_write("./matt.v2.txt", "# nothing\n\n  400 0.25 # end\r\n"
                                                              "500\t0.75"),
                                  &err);
    CHECK_TEXT(err.text, "", "a file of wavelengths and reflectances is a material");
    CHECK_TEXT(m.name, "matt.v2", "its name is the file name without folder and ending");
    CHECK(m.diffuse.kind == SPECTRUM_SAMPLED && m.diffuse.count == 2, "it has two samples");
    CHECK_NEAR(spectrum_at(&m.diffuse, 450, SPECTRUM_HOLD), 0.5, 0,
               "halfway between two samples is their mean");
    CHECK(m.diffuse.place.line == 3 && m.diffuse.place.column == 3 &&
              m.diffuse.place.path == m.path,
          "its source place is its first sample, in a path that lives as long as the material");
    CHECK_TEXT(m.diffuse.name, "matt.v2", "the spectrum is named after the material");
    CHECK(m.gloss == 0 && m.gloss_place.line == 0 && m.specular.kind == SPECTRUM_NONE &&
              m.excitation.kind == SPECTRUM_NONE && m.texture == NULL && m.partner == NULL,
          "values that the file does not define are absent");
    material_free(&m);
    CHECK(m.name == NULL && m.diffuse.count == 0, "a freed material is zeroed");
    material_free(&m);
    m = read_file("builtin:materials/none.txt", &err);
    CHECK(m.name == NULL && err.status == EXIT_INPUT, "a missing material is refused as input");
}

static void check_full_file(void)
{
    struct error err;
    struct material m = read_file(test_write("./full.txt", "g 128\ns 400 0\n400 1\ns 500 1\n"
                                                           "f 380 2 0\nf 520 0 3\n"
                                                           "T \"my wood.tif\"\n500 0\n"),
                                  &err);
    const char *slash = m.texture != NULL ? strrchr(m.texture, '/') : NULL;
    CHECK_TEXT(err.text, "", "lines of all kinds mix in any order, small or capital");
    CHECK(m.gloss == 128 && m.gloss_place.line == 1,
          "gloss 128 and reflectances 0 and 1 are accepted");
    CHECK(m.specular.count == 2 && m.specular.value[1] == 1 && m.diffuse.count == 2 &&
              m.diffuse.value[1] == 0,
          "specular and diffuse samples stay apart");
    CHECK(m.specular.place.line == 2, "the specular source place is its first line");
    CHECK(m.excitation.count == 2 && m.emission.count == 2 && m.excitation.value[0] == 2 &&
              m.emission.value[1] == 3 && m.emission.wavelength_nm[1] == 520,
          "f defines excitation, then emission; they may exceed 1");
    CHECK(slash != NULL && strcmp(slash, "/my wood.tif") == 0 &&
              strncmp(m.texture, m.path, (size_t)(slash - m.texture)) == 0,
          "a quoted texture lies beside the material file");
    material_free(&m);
}

static void check_partner(void)
{
    struct error err;
    struct material m = read_file(test_write("./pair.txt", "400 0.5\ng 10\nmr 400 0.25\nMG 20\n"
                                                           "mS 400 0.75\nmf 380 1 1\n"),
                                  &err);
    CHECK_TEXT(err.text, "", "m lines describe a metameric partner");
    if (CHECK(m.partner != NULL && m.partner_place.line == 3, "the partner begins in line 3")) {
        CHECK(m.partner->diffuse.value[0] == 0.25 && m.partner->specular.value[0] == 0.75 &&
                  m.partner->excitation.count == 1 && m.partner->gloss == 20,
              "the partner has its own values");
        CHECK_TEXT(m.partner->name, "pair", "the partner has the name of its material");
    }
    CHECK(m.diffuse.value[0] == 0.5 && m.gloss == 10 && m.specular.kind == SPECTRUM_NONE &&
              m.excitation.kind == SPECTRUM_NONE,
          "the material keeps its own values");
    material_free(&m);
}

static void check_words(void)
{
    struct error err;
    struct text rest;
    struct word word;
    struct material m = read_words(" diffuse 0.4*0.5 # comment }\n  gloss\n\t30 specular uv*0.1\n"
                                   "fluorescence gaussian:380,40 gaussian:520,60*2\n"
                                   "texture wood.tif linear emission blackbody:2856*0.5\n"
                                   "metamer \"other one\" } tail",
                                   &rest, &err);
    CHECK_TEXT(err.text, "", "words may span lines, with comments between them");
    CHECK_NEAR(spectrum_at(&m.diffuse, 500, SPECTRUM_HOLD), 0.2, 1e-16,
               "the diffuse spectrum has its factor");
    CHECK(m.gloss == 30, "gloss is 30");
    CHECK(m.specular.kind == SPECTRUM_SAMPLED && m.excitation.parameter[0] == 380 &&
              m.emission.factor == 2 && m.glow.kind == SPECTRUM_BLACKBODY,
          "each word fills its own spectrum");
    CHECK_TEXT(m.texture, "scenes/wood.tif", "a texture's path is relative to the scene");
    CHECK(m.texture_filter == TEXTURE_LINEAR, "the filter is linear if the scene says so");
    CHECK_TEXT(m.partner_name, "other one", "a partner is named as in the scene");
    CHECK(m.name == NULL && m.path == NULL && m.partner == NULL,
          "the material has the name and path of the scene");
    CHECK(text_word(&rest, &word) && word_is(&word, "tail"), "reading stops after the }");
    material_free(&m);
    text_free(&rest);
}

static void check_absent_words(void)
{
    static const struct {
        const char *words;
        enum texture_filter filter;
    } filters[] = {{" diffuse 1 spectral-texture s.tif }", TEXTURE_NEAREST},
                   {" diffuse 1 spectral-texture s.tif linear }", TEXTURE_LINEAR},
                   {" diffuse 1 texture a.tif bilinear }", TEXTURE_BILINEAR},
                   {" diffuse 1 texture a.tif nearest }", TEXTURE_NEAREST},
                   {" diffuse 1 texture a.tif }", TEXTURE_NEAREST}};
    struct error err;
    struct text rest;
    struct material m = read_words(" emission 1 }", &rest, &err);
    CHECK(err.status == EXIT_AGREED && m.diffuse.kind == SPECTRUM_CONSTANT &&
              spectrum_at(&m.diffuse, 500, SPECTRUM_HOLD) == 0,
          "a material with emission alone reflects nothing");
    material_free(&m);
    text_free(&rest);
    m = read_words(" diffuse 1 donaldson b.csv spectral-texture s.tif }", &rest, &err);
    CHECK(err.status == EXIT_AGREED && m.donaldson_place.line == 1 && m.spectral_texture &&
              m.donaldson_place.column == 12,
          "a matrix and a stack may be combined");
    CHECK_TEXT(m.donaldson, "scenes/b.csv", "the matrix's path is relative to the scene");
    material_free(&m);
    text_free(&rest);
    for (size_t i = 0; i < sizeof filters / sizeof filters[0]; i++) {
        m = read_words(filters[i].words, &rest, &err);
        CHECK(err.status == EXIT_AGREED && m.texture_filter == filters[i].filter,
              "the filter of%s is number %d", filters[i].words, (int)filters[i].filter);
        material_free(&m);
        text_free(&rest);
    }
    m = read_words(" gloss 10 }", &rest, &err);
    CHECK(err.status == EXIT_INPUT && m.diffuse.kind == SPECTRUM_NONE,
          "gloss alone is refused as a material");
    text_free(&rest);
}

int main(void)
{
    test_enter();
    check_matt_file();
    check_full_file();
    check_partner();
    check_words();
    check_absent_words();
    return test_end();
}
