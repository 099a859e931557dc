// Turns the figures of a comparison into docs/accuracy.md and its pictures, and checks what README
// and docs claim about them.
//     report CSV --docs DIR       writes DIR/accuracy.md and DIR/*.svg
//     report CSV --check FILE...  fails when a claim no longer follows from the figures (claims.h)
#include <stdio.h>
#include <string.h>

#include "charts.h"
#include "claims.h"
#include "page.h"

static bool write_docs(const figures *f, const char *folder)
{
    char path[1024];
    for (int i = 0; i < chart_count; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, charts[i].file);
        if (!chart_possible(f, &charts[i])) {
            fprintf(stderr, "%s: left out, no figures of \"%s\"\n", path, charts[i].experiment);
        } else if (!charts[i].draw(f, path)) {
            fprintf(stderr, "%s: cannot be written\n", path);
            return false;
        }
    }
    snprintf(path, sizeof path, "%s/accuracy.md", folder);
    FILE *page = fopen(path, "w");
    if (page) page_write(f, page);
    if (!page || ferror(page) || fclose(page)) {
        fprintf(stderr, "%s: cannot be written\n", path);
        return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    figures f = {0};
    const bool docs = argc == 4 && !strcmp(argv[2], "--docs");
    const bool check = argc > 3 && !strcmp(argv[2], "--check");
    if (!docs && !check) {
        fprintf(stderr, "report CSV --docs DIR | --check FILE...\n");
        return 2;
    }
    if (!figures_load(&f, argv[1])) return 2;
    int wrong = docs && !write_docs(&f, argv[3]);
    for (int i = 3; check && i < argc; i++) wrong += claims_check(&f, argv[i]);
    figures_free(&f);
    return wrong > 0;
}
