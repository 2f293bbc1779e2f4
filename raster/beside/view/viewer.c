/* SPDX-License-Identifier: MIT */
/* Puts a page together from the files in data/builtin/viewer. A line "<!-- NAME -->" of them stands
 * for another of these files, or for what is different in each page: its kind of scripts, its
 * policy, its data. */
#include <zlib.h>

#include "raster/beside/view/inside.h"

/* ---- data in HTML ---- */

/* A "<" might end the script element around the JSON, so it is escaped; only strings contain one.
 */
void put_json(struct printed *to, const char *id, char *json)
{
    print(to, "<script id=\"%s\" type=\"application/json\">", id);
    for (const char *at = json ? json : ""; *at != '\0';) {
        const size_t plain = strcspn(at, "<");
        print_bytes(to, at, plain);
        at += plain;
        if (*at == '<') {
            print_text(to, "\\u003c");
            at++;
        }
    }
    print_text(to, "</script>\n");
    free(json);
}

/* Encodes bytes as RFC 4648 does. */
static void print_base64(const unsigned char *bytes, size_t length, struct printed *to)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < length; i += 3) {
        const size_t left = length - i;
        const unsigned group = (unsigned)bytes[i] << 16 |
                               (left > 1 ? (unsigned)bytes[i + 1] << 8 : 0) |
                               (left > 2 ? bytes[i + 2] : 0);
        char text[4];
        for (size_t j = 0; j < 4; j++)
            text[j] = j <= left ? digits[group >> (18 - 6 * j) & 63] : '=';
        print_bytes(to, text, sizeof text);
    }
}

static void put_base64(struct printed *to, const char *id, const unsigned char *bytes,
                       size_t length)
{
    print(to, "<script id=\"%s\" type=\"text/plain\">", id);
    print_base64(bytes, length, to);
    print_text(to, "</script>\n");
}

void put_packed(struct printed *to, const char *id, const void *bytes, size_t length,
                struct error *err)
{
    uLongf packed_length = compressBound((uLong)length);
    unsigned char *packed;
    if (MAKE_ARRAY(packed, packed_length, err, "the data of a page") &&
        (compress2(packed, &packed_length, bytes, (uLong)length, Z_DEFAULT_COMPRESSION) == Z_OK ||
         memory_lacks(err, 0, "the data of a page")))
        put_base64(to, id, packed, packed_length);
    free(packed);
}

/* ---- the program, which a live page holds ---- */

static const struct builtin_file *find_module(void)
{
    const struct builtin_file *file;
    struct error missing = {.status = EXIT_AGREED};
    int descriptor;
    file_open(BUILTIN_PREFIX "viewer/spectral.wasm.gz", (struct place){NULL, 0, 0}, &descriptor,
              &file, &missing);
    return file;
}

bool has_live_pages(void)
{
    return find_module() != NULL;
}

/* ---- the page ---- */

/* The security policy forbids a page to fetch or to send anything. A live page may compile the
 * program that it holds, and run it on a thread of its own. */
static const char policy[] =
    "<meta http-equiv=\"Content-Security-Policy\"\n"
    "  content=\"default-src 'none'; script-src 'unsafe-inline'%s; style-src 'unsafe-inline'; "
    "img-src blob: data:%s; base-uri 'none'; form-action 'none'\">\n";

struct page {
    const struct page_parts *parts;
    const struct options *options;
    struct printed text;
    struct error *err;
};

static void put_file(struct page *page, const char *name);

/* Returns whether a file is for pages of other kinds; those that hold the program come last. */
static bool is_left_out(const struct page *page, const char *name)
{
    return (page->parts->kind < PAGE_LIVE && strncmp(name, "live", 4) == 0) ||
           (page->parts->kind == PAGE_STILL && strncmp(name, "stack", 5) == 0);
}

/* Opens the frame of the picture, with the first one in it: browsers show it before the program of
 * the page runs. */
static void put_frame(struct page *page)
{
    const struct page_parts *parts = page->parts;
    if (parts->first.length == 0) {
        print_text(&page->text, "<div id=\"frame\">\n");
        return;
    }
    print(&page->text,
          "<div id=\"frame\" style=\"--width: %dpx; --aspect: %.6g\">\n"
          "<img id=\"first\" width=\"%d\" height=\"%d\" alt=\"Picture of the scene\"\n"
          "  src=\"data:image/png;base64,",
          parts->width, (double)parts->width / parts->height, parts->width, parts->height);
    print_base64((const unsigned char *)parts->first.text, parts->first.length, &page->text);
    print_text(&page->text, "\">\n");
}

/* Puts the controls of the exposure. They begin, and a reset of their form ends, with that of the
 * command line. */
static void put_exposure(struct page *page)
{
    const double factor = exposure_factor(page->options, "auto");
    print(
        &page->text,
        "<div><input type=\"number\" id=\"exposure\" min=\"0\" step=\"any\" value=\"%.*g\">\n"
        "<label class=\"check\"><input type=\"checkbox\" id=\"auto\"%s> automatic</label></div>\n",
        exact_digits(factor), factor > 0 ? factor : 1, factor > 0 ? "" : " checked");
}

/* Puts what a mark stands for. */
static void put_marked(struct page *page, const char *name)
{
    const bool live = page->parts->kind >= PAGE_LIVE;
    if (strcmp(name, "data") == 0)
        print_bytes(&page->text, page->parts->data.text, page->parts->data.length);
    else if (strcmp(name, "body") == 0)
        print_text(&page->text, live ? "<body class=\"live\">\n" : "<body>\n");
    else if (strcmp(name, "frame") == 0)
        put_frame(page);
    else if (strcmp(name, "exposure") == 0)
        put_exposure(page);
    else if (strcmp(name, "policy") == 0)
        print(&page->text, policy, live ? " 'wasm-unsafe-eval'" : "",
              live ? "; worker-src blob:" : "");
    else if (!is_left_out(page, name))
        put_file(page, name);
}

/* Puts each line of a file, or what it stands for. */
static void put_file(struct page *page, const char *name)
{
    char path[128], mark[64];
    snprintf(path, sizeof path, "builtin:viewer/%s", name);
    char *source = file_read(path, NOWHERE, page->err);
    for (const char *at = source ? source : ""; *at != '\0';) {
        const size_t length = strcspn(at, "\n"), n = length + (at[length] == '\n');
        int end = 0;
        if (strncmp(at, "<!-- ", 5) == 0 && sscanf(at, "<!-- %63[^ \n] -->%n", mark, &end) == 1 &&
            (size_t)end == length)
            put_marked(page, mark);
        else
            print_bytes(&page->text, at, n);
        at += n;
    }
    free(source);
}

bool page_write(struct page_parts *parts, struct options *options, size_t *bytes, struct error *err)
{
    const struct builtin_file *module = parts->kind >= PAGE_LIVE ? find_module() : NULL;
    if (module)
        put_base64(&parts->data, "module", module->bytes, module->length);
    struct page page = {.parts = parts, .options = options, .err = err};
    put_file(&page, parts->kind == PAGE_VERIFIER ? "live-verify.html" : "page.html");
    free(printed_take(&parts->data, err)); /* says whether the data are whole */
    free(printed_take(&parts->first, err));
    *bytes = page.text.length;
    return printed_write(&page.text, options->output, &options->outputs, err);
}
