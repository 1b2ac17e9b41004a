// test_fuzz.c - the checks of fuzz.c over a kept corpus (tests/data/fuzz: what libFuzzer found to
// reach each branch, made small) and over numbers at random, denormals flushed and not. --long: 1e8
// lookups of each; --short: few. No statistics: nothing may fail at all. SPDX-License-Identifier:
// MIT
#include <dirent.h>

#include "fuzz.c"
#include "sss_test.h"

#define LOOKUPS 40 // of a medium

static int media_each = 10000, media_flushed = 5000;

static void test_corpus(void **state) {
    DIR *folder = opendir(DATA_DIR "/fuzz");
    int files = 0;
    (void)state;
    if (!folder) fail_msg("cannot read %s", DATA_DIR "/fuzz");
    const struct dirent *entry;
    while ((entry = readdir(folder)) != NULL) {
        if (entry->d_name[0] == '.') continue;
        char path[400];
        snprintf(path, sizeof path, "%s/fuzz/%s", DATA_DIR, entry->d_name);
        FILE *file = fopen(path, "rb");
        if (!file) fail_msg("cannot read %s", path);
        uint8_t data[4096];
        size_t size = fread(data, 1, sizeof data, file);
        fclose(file);
        const char *wrong = fuzz_one(data, size, FUZZ_LOOKUPS);
        if (wrong) fail_msg("%s: %s", path, wrong);
        ++files;
    }
    closedir(folder);
    print_message("%d files\n", files);
    check_at_least("files in the corpus", files, 20.0);
}

// Media are numbered; their four bytes are all that fuzz_one is given.
static void fuzz(int flush, int first_medium, int media) {
    int end = first_medium + media, worst = end;
    const char *first = NULL;
#pragma omp parallel
    {
        st_flush_denormals(flush);
#pragma omp for schedule(dynamic, 256)
        for (int i = first_medium; i < end; ++i) {
            uint8_t data[4];
            for (int k = 0; k < 4; ++k) data[k] = (uint8_t)((uint32_t)i >> (8 * k));
            const char *wrong = fuzz_one(data, 4, LOOKUPS);
#pragma omp critical
            if (wrong && i < worst) worst = i, first = wrong;
        }
        st_flush_denormals(0);
    }
    if (first) fail_msg("medium %d: %s", worst, first);
    print_message("%d media, %d lookups\n", media, media * LOOKUPS);
}

static void test_random(void **state) {
    (void)state;
    fuzz(0, 0, media_each);
}

static void test_random_flushed(void **state) {
    (void)state;
    if (!ST_CAN_FLUSH) skip();
    fuzz(1, 0, media_flushed);
    fuzz(1, 35371, 1); // a faint hit, beside which another channel's profile is nearly flushed
}

int main(int count, char **words) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_corpus),
        cmocka_unit_test(test_random),
        cmocka_unit_test(test_random_flushed),
    };
    if (count > 1 && strcmp(words[1], "--long") == 0) media_each = media_flushed = 2500000;
    if (count > 1 && strcmp(words[1], "--short") == 0)
        media_each = media_flushed = 100; // where each step is slow
    return cmocka_run_group_tests_name("fuzzing", tests, NULL, NULL);
}
