/* SPDX-License-Identifier: MIT */
/* Names of files. A word names a built-in file by the name that `spectral list` prints, or a file
 * of the user. */
#include <strings.h>

#include "data/text/text.h"

/* How messages call a kind of files, what they say where no name is near (NULL: they list the
 * built-in ones), and where these lie. A spectrum may also be the reflectance of a material file.
 */
static const struct {
    const char *what, *otherwise;
    struct {
        const char *folder, *ending;
    } places[2];
} kinds[] = {
    [FILE_SCENE] = {"scene", NULL, {{"scenes/", ".scene"}, {"", ".scene"}}}, /* hard/mirror */
    [FILE_MATERIAL] = {"material", "see spectral list materials", {{"materials/", ".txt"}}},
    [FILE_LIST] = {"list of materials", NULL, {{"materials/", ".list"}}},
    [FILE_TABLE] = {"spectrum", NULL, {{"tables/", ".csv"}, {"materials/", ".txt"}}},
    [FILE_MODEL] = {"model", "meshes are OBJ; see spectral list models", {{"models/", ".obj"}}},
    [FILE_MAP] = {"material map", NULL, {{"models/", ".map"}}},
    [FILE_TEXTURE] = {"texture", "see spectral list textures", {{"textures/", ".tif"}}},
    [FILE_RELIEF] = {"relief", "see spectral list reliefs", {{"reliefs/", ".tif"}}},
    [FILE_KINDS] = {"file", NULL, {{NULL, NULL}}},
};

/* ---- built-in files ---- */

bool builtin_is(const struct builtin_file *file, enum file_kind kind, char out[BUILTIN_NAME])
{
    for (int i = 0; i < 2 && kinds[kind].places[i].folder; i++)
        if (builtin_name(file, kinds[kind].places[i].folder, kinds[kind].places[i].ending, out))
            return true;
    return false;
}

/* Finds the built-in file of that name; NULL: there is none. */
static const struct builtin_file *find(const char *name, enum file_kind kind, bool exact)
{
    char known[BUILTIN_NAME];
    for (size_t i = 0; i < builtin_file_count; i++)
        if (builtin_is(&builtin_files[i], kind, known) &&
            (exact ? strcmp(name, known) : strcasecmp(name, known)) == 0)
            return &builtin_files[i];
    return NULL;
}

/* ---- words ---- */

bool word_file(const struct word *word, enum file_kind kind, char **out, struct error *err)
{
    *out = NULL;
    if (word->length == 0)
        return error_at(err, word->place, "a file name must not be empty");
    char *name = word_copy(word, err);
    const struct builtin_file *found = name ? find(name, kind, true) : NULL;
    if (name && !found) {
        *out = file_relative(word->place.path, name);
        found = *out && file_is_missing(*out) ? find(name, kind, false) : NULL;
    }
    if (found) {
        free(*out);
        *out = file_relative(BUILTIN_PREFIX, found->name);
    }
    free(name);
    return *out || memory_lacks(err, (double)word->length, "the name of a file");
}

bool word_file_or_here(const struct word *word, enum file_kind kind, char **out, struct error *err)
{
    if (!word_file(word, kind, out, err))
        return false;
    if (!file_is_missing(*out))
        return true;
    char *here = word_copy(word, err);
    if (here && !file_is_missing(here)) {
        free(*out);
        *out = here;
    } else {
        free(here);
    }
    return here != NULL;
}

void suggestion_add_files(struct suggestion *suggestion, const char *path, enum file_kind kind)
{
    const struct word typed = {.start = path_name(path), .length = strlen(path_name(path))};
    const struct word stem = {.start = typed.start, .length = strcspn(typed.start, ".")};
    const char *endings[] = {strrchr(typed.start, '.'), kinds[kind].places[0].ending};
    char *folder = file_relative(path, ".");
    DIR *entries = folder ? opendir(folder) : NULL;
    for (const struct dirent *entry; entries && (entry = readdir(entries)) != NULL;) {
        const char *dot = strrchr(entry->d_name, '.');
        for (int i = 0; dot && i < 2; i++)
            if (endings[i] && strcmp(dot, endings[i]) == 0)
                suggestion_add(suggestion, i == 0 ? &typed : &stem, entry->d_name,
                               strlen(entry->d_name));
    }
    if (entries)
        closedir(entries);
    free(folder);
    suggestion->known[0] = '\0';
}

bool file_expected(const char *path, struct place from, enum file_kind kind, struct error *err)
{
    const bool hard = strncmp(path, "hard/", 5) == 0; /* such names have their folder */
    const char *name = hard ? path : path_name(path);
    const struct word typed = {.start = name, .length = strcspn(name, ".")}; /* without an ending */
    struct suggestion suggestion = {.distance = 0};
    const char *otherwise = hard ? "see spectral list hard" : kinds[kind].otherwise;
    char known[BUILTIN_NAME];
    if (!file_is_missing(path))
        return true;
    suggestion_add_files(&suggestion, path, kind);
    for (size_t i = 0; i < builtin_file_count; i++)
        if (builtin_is(&builtin_files[i], kind, known) &&
            (kind != FILE_SCENE || !strchr(known, '/') == !hard))
            suggestion_add(&suggestion, &typed, known, strlen(known));
    if (otherwise)
        suggestion.known[0] = '\0';
    return error_at(err, from, "no file %.500s and no built-in %s of that name; %s", path,
                    kinds[kind].what,
                    suggestion_end(&suggestion, otherwise ? otherwise : "built-in are"));
}
