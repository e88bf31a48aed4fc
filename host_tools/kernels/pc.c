// What kernels need of Python on a PC, where ctypes calls them: instead of MicroPython's table, functions that native.py gives. Between
// these lines and the next stand the numbers of runtime.c.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    void *numbers;     // of an array
    const void *code;  // of a kernel: its wrapper
    int64_t number;    // of an object: native.py knows it by that
} *object_t;
typedef const struct {
    object_t (*attribute)(object_t, int32_t);
    object_t (*call)(object_t, int32_t, int32_t, object_t *);  // a function, or an object's method of that name; below 0: none
    object_t (*make)(int32_t);
    object_t (*array)(const volatile void *);
    int32_t (*to_int)(object_t);
    void *(*numbers)(object_t);
} *context_t;

#define NAME(number) (number)
#define FUNCTION static __attribute__((noinline, unused))
#define INLINE static inline __attribute__((always_inline, unused))
/* numbers */
#define load_attr(base, name) at->attribute((base), (name))
#define call_object(function, count, ...) at->call((function), -1, (count), (object_t[]){0, ## __VA_ARGS__} + 1)
#define call_method(base, name, count, ...) at->call((base), (name), (count), (object_t[]){0, ## __VA_ARGS__} + 1)

INLINE int32_t to_int(context_t at, object_t o) {
    return at->to_int(o);
}

INLINE object_t to_object(context_t at, int32_t value) {
    return at->make(value);
}

INLINE object_t to_pointer(context_t at, const volatile void *pointer) {
    return at->array(pointer);
}

INLINE void *array_of(context_t at, object_t o) {
    return o->numbers ? o->numbers : at->numbers(o);
}

INLINE bool is_kernel(object_t o, const void *wrapper) {
    return o->code == wrapper;
}

INLINE int32_t root(int32_t value) {
    return value > 0 ? (int32_t)__builtin_sqrt((double)value) : 0;  // exact: a double holds 53 bits
}
