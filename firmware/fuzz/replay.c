/* SPDX-License-Identifier: Apache-2.0 */

/* Runs a fuzz target once with each file in the arguments. */

#include <stdio.h>
#include <stdlib.h>

#include "fuzz_target.h"

enum { INPUT_MOST = 65536 };

int main(int number, char **names) {
    static uint8_t buffer[INPUT_MOST];
    for (int place = 1; place < number; place++) {
        FILE *file = fopen(names[place], "rb");
        if (file == NULL) {
            fprintf(stderr, "%s cannot be read\n", names[place]);
            return EXIT_FAILURE;
        }
        size_t size = fread(buffer, 1, sizeof buffer, file);
        fclose(file);
        /* The buffer has exactly the size of the input, so that AddressSanitizer detects a read beyond its end. */
        uint8_t *input = malloc(size ? size : 1);
        if (!input) {
            perror("replay");
            return EXIT_FAILURE;
        }
        for (size_t byte = 0; byte < size; byte++) {
            input[byte] = buffer[byte];
        }
        (void)LLVMFuzzerTestOneInput(input, size);
        free(input);
    }
    printf("%d inputs\n", number - 1);
    return EXIT_SUCCESS;
}
