/* SPDX-License-Identifier: MIT */
/* Reads tables of columns: a wavelength and its values a row; or a sample a row, with the
 * wavelengths in the heading. What can be read in two ways is refused, with the words that decide.
 */
#include "data/spectra/inside.h"

/* ---- what a line is ---- */

enum { SAYS_NOTHING = 256 }; /* the cell is empty */
struct line {
    struct table at;                  /* with its own separator */
    int n_cells, n_filled, n_columns; /* n_columns: up to the last that is filled */
    int n_numbers;   /* as some country writes them; also a wavelength with a unit */
    int n_nm, steps; /* wavelengths above 100 nm; steps upwards minus steps downwards */
    bool is_units;   /* all cells name a unit, or wavelengths */
    double first;    /* its first number in nm, 0: below 100 nm; NAN: it begins with none */
    double last_nm;
    unsigned says;    /* its first cell */
    struct word said; /* the first cell that says percent, or another quantity */
};

/* Reads the cell of a wavelength, whose unit may stand behind a blank. */
static bool wavelength_cell(struct table *table, struct word *out)
{
    struct table ahead;
    struct word unit;
    if (!line_cell(table, out))
        return false;
    ahead = *table;
    if (table->separator == ' ' && line_cell(&ahead, &unit) && word_is(&unit, "nm"))
        *table = ahead;
    return true;
}

static void line_add(struct line *line, const struct word *cell)
{
    const double found = heading_nm(cell, false);
    const bool number = word_is_numeric(cell, "0123456789+-.,%eE"), first = line->n_cells == 0;
    struct meaning meaning;
    heading_read(cell, &meaning);
    line->is_units = line->is_units && (cell->length == 0 || meaning.is_unit);
    line->n_cells++;
    line->n_filled += cell->length > 0;
    line->n_columns = cell->length > 0 ? line->n_cells : line->n_columns;
    line->n_numbers += number || (first && found > 0);
    if (first)
        line->says = cell->length > 0 ? meaning.says : (unsigned)SAYS_NOTHING;
    if (first && (number || found > 0))
        line->first = found;
    if (line->said.length == 0 && meaning.says & (SAYS_PERCENT | SAYS_OTHER))
        line->said = *cell;
    if (found == 0)
        return;
    if (line->n_nm++ > 0)
        line->steps += (found > line->last_nm) - (found < line->last_nm);
    line->last_nm = found;
}

/* separator: of the other lines, if they are known. It goes before the line's own, where the line
 * has it. */
static struct line line_look(const struct table *table, char separator)
{
    const struct text *text = &table->text;
    struct line line = {.at = *table, .first = (double)NAN, .is_units = true};
    struct word cell;
    line_begin(&line.at);
    if (separator != ' ' &&
        memchr(text->line_start, separator, (size_t)(text->line_end - text->line_start)))
        line.at.separator = separator;
    struct table rest = line.at;
    for (bool more = wavelength_cell(&rest, &cell); more; more = line_cell(&rest, &cell))
        line_add(&line, &cell);
    return line;
}

static bool is_row(const struct line *line)
{
    return !isnan(line->first) && line->n_filled > 1 && line->n_numbers == line->n_filled;
}

/* ---- the lines of a table ---- */

struct layout {
    struct line first;        /* the first row, or, `of_rows`, the heading of its wavelengths */
    struct line names, units; /* the headings above it */
    struct line broken;       /* the first that begins with a number and is no row */
    struct word above;        /* what lines above these say: see struct sample */
    bool of_rows;
};

/* Keeps what a line says, unless an earlier one has said something. */
static void note_said(const struct line *line, struct word *above)
{
    if (above->length == 0)
        *above = line->said;
}

/* Marks of Ocean Optics' programs stand around the rows, and DOS ends files with Ctrl-Z. */
static bool is_mark(const struct text *text)
{
    return strncmp(text->line_start, ">>>>>", 5) == 0 || *text->line_start == '\x1a';
}

/* Goes on to the next line that is neither blank nor a mark. */
static bool next_line(struct table *table, char separator, struct line *out)
{
    while (text_next_line(&table->text)) {
        *out = line_look(table, separator);
        if (out->n_filled > 0 && !is_mark(&table->text))
            return true;
    }
    return false;
}

/* Finds whether each row behind a heading of wavelengths is a sample. */
static bool find_order(const struct line *heading, bool *of_rows, struct error *err)
{
    struct table rest = heading->at;
    struct line next;
    *of_rows = heading->n_nm > 1 && abs(heading->steps) == heading->n_nm - 1 && !is_row(heading) &&
               next_line(&rest, heading->at.separator, &next) && next.n_numbers > 0;
    if (!*of_rows || !is_row(&next))
        return true;
    *of_rows = !(heading->says & SAYS_WAVELENGTH);
    return heading->says & (SAYS_WAVELENGTH | SAYS_LABEL) || !(next.first >= 100) ||
           error_at(err, text_place(&heading->at.text),
                    "the numbers of this heading may be wavelengths, if each row is a sample, or "
                    "names of columns; write 'name' before them, or 'wavelength'");
}

static bool refuse_row(const struct line *line, struct error *err)
{
    struct table rest = line->at;
    struct word cell = {.length = 0};
    while (line_cell(&rest, &cell) &&
           (cell.length == 0 || word_is_numeric(&cell, "0123456789+-.,%eE")))
        ;
    if (line->n_filled == 1)
        return error_at(err, text_place(&rest.text), "expected a value after the wavelength");
    return error_at(err, cell.place,
                    "expected a number, found '%.*s'; put # before a line that is no row of the "
                    "table",
                    word_shown(&cell), cell.start);
}

/* Refuses what may be a row whose wavelength is no number: its values would become names. */
static bool check_names(const struct line *line, struct error *err)
{
    const struct text *text = &line->at.text;
    if (line->n_filled > 0 && line->n_numbers == line->n_filled &&
        memchr(text->line_start, '.', (size_t)(text->line_end - text->line_start)))
        return error_at(err, text_place(text), "expected a wavelength");
    return line->n_filled < 2 || line->n_numbers < line->n_filled - 1 ||
           line->says & (SAYS_WAVELENGTH | SAYS_LABEL | SAYS_NOTHING) || refuse_row(line, err);
}

/* Finds which line is what. A line above the first row is a heading, unless it begins with a number
 * and has another one. */
static bool find_layout(struct table table, struct layout *out, struct error *err)
{
    struct line line;
    *out = (struct layout){.of_rows = false};
    while (next_line(&table, 0, &line)) {
        if (!find_order(&line, &out->of_rows, err))
            return false;
        if (out->of_rows || is_row(&line)) {
            out->first = line;
            break;
        }
        if (!isnan(line.first) && line.n_numbers > 1)
            return refuse_row(&line, err);
        if (!isnan(line.first) && out->broken.n_cells == 0)
            out->broken = line;
        if (line.is_units && out->names.n_cells > 1) {
            out->units = line;
            continue;
        }
        note_said(&out->names, &out->above);
        note_said(&out->units, &out->above);
        out->names = line;
        out->units = (struct line){.n_cells = 0};
    }
    if (out->names.n_cells > 0)
        out->names = line_look(&out->names.at, out->first.at.separator);
    if (out->units.n_cells > 0)
        out->units = line_look(&out->units.at, out->first.at.separator);
    if (!out->of_rows && out->names.n_cells == 0 && out->first.n_cells > 3 &&
        2 * out->first.n_nm == out->first.n_cells)
        return error_at(err, text_place(&out->first.at.text),
                        "this line may be pairs of a wavelength and a value, or a wavelength and "
                        "%d values; write a pair a line, or names above the columns",
                        out->first.n_cells - 1);
    return out->first.n_cells == 0 || out->of_rows || check_names(&out->names, err);
}

bool columns_found(struct text text)
{
    struct layout layout;
    struct error own = {.status = EXIT_AGREED};
    return !find_layout((struct table){.text = text}, &layout, &own) || layout.first.n_cells > 0;
}

/* ---- headings ---- */

/* Takes what a heading says of each column. Where its cells do not fit the columns none is a name,
 * and one is the unit of the wavelengths, if the first speaks of these. */
static bool read_heading(struct table *table, const struct line *line, int n_columns, bool names,
                         struct error *err)
{
    struct table rest = line->at;
    struct word cell, first = {.length = 0};
    struct meaning meaning;
    const bool fits = line->n_columns <= n_columns, leads = line->says & SAYS_WAVELENGTH;
    bool more = line->n_cells > 0 && wavelength_cell(&rest, &cell);
    for (int k = 0; more; more = line_cell(&rest, &cell), k++) {
        first = k == 0 ? cell : first;
        heading_read(&cell, &meaning);
        const bool of_wavelengths = fits ? k == 0 : leads;
        table->to_nm *= of_wavelengths ? meaning.to_nm : 1;
        if (of_wavelengths && meaning.advice)
            return error_at(err, cell.place, "'%.*s' is no wavelength; wavelengths in nm are %s",
                            word_shown(&cell), cell.start, meaning.advice);
        if (k == 0 || k >= n_columns || !fits)
            continue;
        if (names && meaning.says & SAYS_WAVELENGTH && rest.separator != ' ')
            return leads
                       ? error_at(err, cell.place,
                                  "'%.*s' heads the wavelengths of another pair of columns; write "
                                  "each pair into a file of its own (data/samples/to_csv.py)",
                                  word_shown(&cell), cell.start)
                       : error_at(err, first.place,
                                  "the first column must hold the wavelengths; it is named "
                                  "'%.*s'",
                                  word_shown(&first), first.start);
        struct sample *sample = &table->sample[k - 1];
        if (meaning.says & (SAYS_PERCENT | SAYS_QUANTITY) && sample->says.length == 0)
            sample->says = cell;
        if (names && !table_add_name(table, k - 1, &cell, false, err))
            return false;
    }
    return true;
}

/* ---- rows ---- */

static bool read_wavelength(struct table *table, struct word *cell, struct reading *out,
                            struct error *err)
{
    if (cell->length > 2 && strncmp(cell->start + cell->length - 2, "nm", 2) == 0)
        for (cell->length -= 2; strchr(" \t", cell->start[cell->length - 1]);)
            cell->length--;
    out->nm_column = cell->place.column;
    if (!word_is_numeric(cell, "0123456789+-.,eE"))
        return error_at(err, cell->place,
                        "expected a wavelength in nm, found '%.*s'; put # before a line that is no "
                        "row of the table",
                        word_shown(cell), cell->start);
    if (!table_number(table, cell, "wavelength", &out->nm, err))
        return false;
    out->nm *= table->to_nm;
    return true;
}

/* Reads the current line. Empty cells may stand behind the last value only. */
static bool read_row(struct table *table, struct error *err)
{
    struct place empty = {0};
    struct word cell;
    struct reading at = {.nm = 0};
    int n = 0;
    for (bool more = wavelength_cell(table, &cell); more; more = line_cell(table, &cell)) {
        if (cell.length == 0 && !cell.quoted) {
            empty = empty.line > 0 ? empty : cell.place;
            continue;
        }
        if (empty.line > 0)
            return error_at(err, empty, n == 0 ? "expected a wavelength" : "this cell is empty");
        if (n == 0 ? !read_wavelength(table, &cell, &at, err)
                   : n <= table->n_samples && !table_add(table, n - 1, &at, &cell, err))
            return false;
        n++;
    }
    if (n == 1)
        return error_at(err, text_place(&table->text), "expected a value after the wavelength");
    return n == 0 || n == table->n_samples + 1 ||
           error_at(err, text_place(&table->text), "this row has %d values, the first row has %d",
                    n - 1, table->n_samples);
}

static bool read_rows(struct table *table, const struct layout *layout, struct error *err)
{
    const int n = layout->first.n_columns;
    bool done = true;
    while (done && table->n_samples < n - 1)
        done = table_add_sample(table, err);
    done = done && read_heading(table, &layout->names, n, true, err) &&
           read_heading(table, &layout->units, n, false, err);
    while (done && !is_mark(&table->text) && (done = read_row(table, err)) &&
           text_next_line(&table->text))
        ;
    return done;
}

bool columns_read(struct table *table, struct error *err)
{
    struct layout layout;
    const struct line *first = &layout.first;
    if (!find_layout(*table, &layout, err))
        return false;
    if (first->n_cells == 0)
        return layout.broken.n_cells == 0 || refuse_row(&layout.broken, err);
    if (layout.names.n_columns > first->n_columns)
        note_said(&layout.names, &layout.above);
    table->text = first->at.text;
    table->separator = first->at.separator;
    const bool done = layout.of_rows ? samples_read(table, err) : read_rows(table, &layout, err);
    if (table->above.length == 0)
        table->above = layout.above;
    return done;
}
