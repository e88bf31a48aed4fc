// What kernels need of MicroPython, without its headers: the table of functions that viper's code uses too. Its order, and that of a
// function's words, go with .mpy files of version 6.3; the interpreter loads no others.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *object_t;
typedef const struct function {
    const void *type;
    const struct {
        void *module_type, *globals;
        const uint16_t *names;
        void *const *objects;  // of the .mpy: the table
    } *context;
    object_t arrays;  // the type of array.array; 0 if its numbers do not lie where they are looked for
    const void *code;
} *context_t;  // the function that Python has called: so nothing of a module has to stay in memory that can be written

#define TABLE(number, type) ((type)((void *const *)at->context->objects[0])[number])
#define NAME(number) (at->context->names[number])
#define load_attr TABLE(9, object_t (*)(object_t, uintptr_t))
#define SMALL_INT(value) ((object_t)((uintptr_t)(intptr_t)(value) << 1 | 1))
#define AS_INT 2
#define AS_PTR32 7
#define FUNCTION static __attribute__((noinline, unused))
#define INLINE static inline __attribute__((always_inline, unused))

// --- numbers: whatever they are, what comes out is defined

INLINE int32_t left(int32_t a, int32_t by) {
    return (uint32_t)by < 32 ? (int32_t)((uint32_t)a << by) : 0;
}

INLINE int32_t right(int32_t a, int32_t by) {
    return a >> ((uint32_t)by < 32 ? by : 31);
}

#if defined(__ARM_ARCH_6M__)
// The RP2040's divider. Who finds it in use has interrupted somebody, and puts it back. By 0 there is 0, and nothing is left.
#define DIVIDER ((volatile int32_t *)0xd0000060)
#define WAIT8 __asm volatile("b 1f\n1: b 1f\n1: b 1f\n1: b 1f\n1:")
FUNCTION int32_t divide_amid(int32_t a, int32_t b, int32_t *rest) {
    volatile int32_t *d = DIVIDER;
    WAIT8;
    int32_t s0 = d[0], s1 = d[1], s5 = d[5], s4 = d[4];
    d[2] = a;
    d[3] = b;
    WAIT8;
    *rest = d[5];
    int32_t q = d[4];
    d[0] = s0;
    d[1] = s1;
    d[5] = s5;
    d[4] = s4;
    return q;
}
INLINE int32_t divide(int32_t a, int32_t b, int32_t *rest) {
    volatile int32_t *d = DIVIDER;
    if (d[6] & 2) return divide_amid(a, b, rest);
    d[2] = a;
    d[3] = b;
    WAIT8;
    *rest = d[5];
    return d[4];  // last: it is not in use again
}
#else
INLINE int32_t divide(int32_t a, int32_t b, int32_t *rest) {
    if (b == -1) return *rest = 0, (int32_t)(0 - (uint32_t)a);
    *rest = a % b;
    return a / b;
}
#endif

FUNCTION int32_t divided_by_any(int32_t a, int32_t b) {
    if (b == 0) return 0;
    int32_t rest, q = divide(a, b, &rest);
    return rest && (rest ^ b) < 0 ? q - 1 : q;
}

FUNCTION int32_t modulo_of_any(int32_t a, int32_t b) {
    if (b == 0) return 0;
    int32_t rest;
    divide(a, b, &rest);
    return rest && (rest ^ b) < 0 ? rest + b : rest;
}

#define POWER_OF_TWO(b) (__builtin_constant_p(b) && (b) > 0 && ((b) & ((b) - 1)) == 0)

INLINE int32_t divided(int32_t a, int32_t b) {
    return POWER_OF_TWO(b) ? a >> __builtin_ctz(b) : divided_by_any(a, b);
}

INLINE int32_t modulo(int32_t a, int32_t b) {
    return POWER_OF_TWO(b) ? a & (b - 1) : modulo_of_any(a, b);
}

// --- what interrupts or hardware read and write: what comes before such an access is done before it, what comes behind, behind it

INLINE void settled(void) {
    __asm volatile("" ::: "memory");
}

#define looked(element) ({ int32_t looked_at = (element); settled(); looked_at; })

// --- objects

INLINE int32_t to_int(context_t at, object_t o) {
    return (intptr_t)o & 1 ? (int32_t)((intptr_t)o >> 1) : (int32_t)TABLE(3, uintptr_t (*)(object_t, uintptr_t))(o, AS_INT);
}

FUNCTION object_t to_object(context_t at, int32_t value) {
    if ((uint32_t)value + 0x40000000u < 0x80000000u) return SMALL_INT(value);
    return TABLE(4, object_t (*)(uintptr_t, uintptr_t))((uintptr_t)(intptr_t)value, AS_INT);
}

INLINE object_t to_pointer(context_t at, const volatile void *pointer) {
    return sizeof pointer == 4 ? to_object(at, (int32_t)(uintptr_t)pointer) : SMALL_INT((intptr_t)pointer);
}

INLINE object_t none(context_t at) {
    return TABLE(0, object_t);
}

INLINE object_t to_bool(context_t at, int32_t value) {
    return value ? TABLE(2, object_t) : TABLE(1, object_t);
}

// Where the numbers of an array, or of what else has a buffer, lie.
FUNCTION void *array_of(context_t at, object_t o) {
    if (((uintptr_t)o & 3) == 0 && at->arrays && *(object_t *)o == at->arrays) return ((void **)o)[3];
    return (void *)TABLE(3, uintptr_t (*)(object_t, uintptr_t))(o, AS_PTR32);
}

FUNCTION void wrong_count(context_t at, size_t wanted, size_t count) {
    TABLE(44, void (*)(size_t, size_t, uint32_t))(count, 0, (uint32_t)(wanted << 17 | wanted << 1));
}

INLINE bool is_kernel(object_t o, const void *wrapper) {
    return ((uintptr_t)o & 3) == 0 && ((context_t)o)->code == wrapper;
}

#define call_object(function, count, ...) TABLE(27, object_t (*)(object_t, size_t, const object_t *))((function), (count), (object_t[]){0, ## __VA_ARGS__} + 1)
#define call_method(base, name, count, ...) called_method(at, (base), (name), (count), (object_t[]){0, 0, ## __VA_ARGS__})
INLINE object_t called_method(context_t at, object_t base, uintptr_t name, size_t count, object_t *args) {
    TABLE(10, void (*)(object_t, uintptr_t, object_t *))(base, name, args);
    return TABLE(28, object_t (*)(size_t, size_t, const object_t *))(count, 0, args);
}

// --- the module's beginning: it defines a function for each kernel

// Runs once, and is not copied with the rest.
#define ONCE static __attribute__((noinline, used, section(".text.once")))

ONCE void define(context_t at, uintptr_t name, const void *code, object_t arrays) {
    const void *raw[] = {(void *)(uintptr_t)(4 << 16), code, arrays, 0};  // mp_raw_code_t, of viper's kind
    object_t function = TABLE(26, object_t (*)(const void *, const void *, const void *))(raw, at->context, 0);
    TABLE(13, void (*)(uintptr_t, object_t))(name, function);
}

ONCE void define_all(context_t at, object_t arrays, intptr_t away);

#if defined(__arm__) && !defined(STAYS)
extern const char code_begin[] __attribute__((visibility("hidden")));  // of the linker
extern const char code_end[] __attribute__((visibility("hidden")));

// Frozen code lies in flash, from where it is half as fast: it is copied into memory. How far away that is; 0 if it stays where it is.
ONCE intptr_t copied(context_t at) {
    const char *code = code_begin;
    size_t size = code_end - code;
    if ((uintptr_t)code >> 28 != 1) return 0;
    char *copy = TABLE(52, void *(*)(void *, size_t, bool))(0, size, false);
    if (!copy) return 0;
    TABLE(51, void *(*)(void *, const void *, size_t))(copy, code, size);
    TABLE(13, void (*)(uintptr_t, object_t))(NAME(2), TABLE(59, object_t (*)(size_t, void *))(size, copy));
    return copy - code;
}
#else
#define copied(at) 0
#endif

__attribute__((section(".text.start"), used)) object_t start(context_t at, size_t count, size_t named, object_t *args) {
    object_t module = TABLE(35, object_t (*)(uintptr_t, object_t, object_t))(NAME(1), none(at), SMALL_INT(0));
    object_t arrays = load_attr(module, NAME(1));
    // A trial: whether the numbers of an array lie where its fourth word says. If not, the interpreter is asked each time.
    object_t numbers[2] = {SMALL_INT(5), SMALL_INT(8)};
    object_t made = call_object(arrays, 2, (object_t)((uintptr_t)NAME(3) << 3 | 2), TABLE(19, object_t (*)(size_t, const object_t *))(2, numbers));
    int32_t *place = ((int32_t **)made)[3];
    if (*(object_t *)made != arrays || place != (int32_t *)TABLE(3, uintptr_t (*)(object_t, uintptr_t))(made, AS_PTR32) || place[1] != 8) arrays = 0;
    void *before = TABLE(5, void *(*)(void *))(at->context->globals);
    intptr_t away = copied(at);
    if (!away) TABLE(13, void (*)(uintptr_t, object_t))(NAME(2), (object_t)at);  // its code is where all begins: the collector keeps what is pointed to so
    define_all(at, arrays, away);
    TABLE(5, void *(*)(void *))(before);
    return none(at);
}
