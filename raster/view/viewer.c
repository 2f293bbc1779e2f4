/* SPDX-License-Identifier: MIT */
/* Puts a page together from the files in data/builtin/viewer. A line "<!-- NAME -->" of them stands
 * for another of these files, or for what is different in each page: its kind of scripts, its
 * policy, its data. */
#include <stdlib.h>
#include <string.h>

#include "raster/view/view.h"

/* ---- data in HTML ---- */

/* Writes JSON into HTML. A "<" might end the script element around it, so it is escaped; only
 * strings contain one. */
static void write_json(const char *text, struct printed *to)
{
    while (*text) {
        const size_t plain = strcspn(text, "<");
        print_bytes(to, text, plain);
        text += plain;
        if (*text == '<') {
            print_text(to, "\\u003c");
            text++;
        }
    }
}

void put_json(struct printed *to, const char *id, const char *json)
{
    print(to, "<script id=\"%s\" type=\"application/json\">", id);
    write_json(json, to);
    print_text(to, "</script>\n");
}

void put_base64(struct printed *to, const char *id, const char *text, size_t length)
{
    print(to, "<script id=\"%s\" type=\"text/plain\">", id);
    print_bytes(to, text, length);
    print_text(to, "</script>\n");
}

/* ---- the page ---- */

/* The security policy forbids a page to fetch or to send anything. A live page may compile the
 * program that it holds, and run it on a thread of its own. */
static const char policy[] =
    "<meta http-equiv=\"Content-Security-Policy\"\n"
    "  content=\"default-src 'none'; script-src 'unsafe-inline'%s; style-src 'unsafe-inline'; "
    "img-src blob: data:%s; base-uri 'none'; form-action 'none'\">\n";

static bool put_file(struct page *page, const char *name, struct error *err);

/* Returns whether a file is for pages of other kinds. */
static bool is_left_out(const struct page *page, const char *name)
{
    return (page->kind != PAGE_LIVE && strncmp(name, "live", 4) == 0) ||
           (page->kind == PAGE_STILL && strncmp(name, "stack", 5) == 0);
}

/* Puts what a mark stands for. */
static bool put_marked(struct page *page, const char *name, struct error *err)
{
    const bool live = page->kind == PAGE_LIVE;
    if (strcmp(name, "data") == 0)
        return page->put_data(page, err);
    if (strcmp(name, "policy") != 0)
        return is_left_out(page, name) || put_file(page, name, err);
    print(&page->text, policy, live ? " 'wasm-unsafe-eval'" : "", live ? "; worker-src blob:" : "");
    return true;
}

/* Puts a line, or what it stands for. Returns false after an error. */
static bool put_line(struct page *page, const char *line, size_t length, struct error *err)
{
    static const char before[] = "<!-- ", after[] = " -->\n";
    const size_t n_before = sizeof before - 1, n_after = sizeof after - 1;
    char name[64];
    if (length <= n_before + n_after || length >= sizeof name + n_before + n_after ||
        memcmp(line, before, n_before) != 0 ||
        memcmp(line + length - n_after, after, n_after) != 0 ||
        memchr(line + n_before, ' ', length - n_before - n_after)) {
        print_bytes(&page->text, line, length);
        return true;
    }
    snprintf(name, sizeof name, "%.*s", (int)(length - n_before - n_after), line + n_before);
    return put_marked(page, name, err);
}

static bool put_file(struct page *page, const char *name, struct error *err)
{
    char path[128], *source;
    size_t length;
    snprintf(path, sizeof path, "builtin:viewer/%s", name);
    if (!file_read(path, (struct place){NULL, 0, 0}, &source, &length, err))
        return false;
    bool done = true;
    for (const char *at = source; done && *at != '\0';) {
        const char *end = strchr(at, '\n');
        const size_t n = end ? (size_t)(end - at) + 1 : strlen(at);
        done = put_line(page, at, n, err);
        at += n;
    }
    free(source);
    return done;
}

bool page_write(struct page *page, const char *path, size_t *bytes, struct outputs *outputs,
                struct error *err)
{
    const bool put = put_file(page, "page.html", err);
    char *text = printed_end(&page->text);
    *bytes = page->text.length;
    const bool done =
        put && (text ? file_write(path, text, *bytes, outputs, err) : error_memory(err));
    free(text);
    return done;
}
