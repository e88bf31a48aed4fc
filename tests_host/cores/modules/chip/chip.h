/* Memory of a chip whose heap is in pieces, in the place of qemu's: see chip.c. */
#include <stddef.h>
void *chip_heap(size_t bytes);
void *chip_commit(void *code, size_t bytes, void *relocations);
#define MICROPY_GC_SPLIT_HEAP (1)
#define MICROPY_GC_SPLIT_HEAP_AUTO (1)
#define MP_PLAT_ALLOC_HEAP(bytes) chip_heap(bytes)
#define MP_PLAT_FREE_HEAP(at)
#define MP_PLAT_COMMIT_EXEC(code, bytes, relocations) chip_commit(code, bytes, relocations)
