/* libFuzzer: clang -g -O1 -fsanitize=fuzzer,address,undefined; what is done is in exercise.h.
 * SPDX-License-Identifier: MIT */
#include "exercise.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    exercise(data, size);
    return 0;
}
