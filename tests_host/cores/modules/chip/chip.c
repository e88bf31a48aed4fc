/* The memory of a chip for the qemu port: a heap that grows by pieces as an ESP32's does (ports/esp32), machine code in what is left.
 *
 *     chip.pieces(112000, 20000, 10800)   # what is there beside the first heap; the last one holds code only
 *     chip.take(40000)                    # a driver's; False: there is no piece for it
 *     chip.left()                         # (bytes free in each piece, …)
 *     chip.code()                         # bytes of machine code so far
 *
 * Without pieces() nothing is bounded.
 */

#include <string.h>

#include "py/gc.h"
#include "py/nativeglue.h"
#include "py/persistentcode.h"
#include "py/runtime.h"

#define ARENA (8u << 20)
#define MOST 8

static uint8_t arena[ARENA] __attribute__((aligned(16)));
static struct { size_t begin, end; } pieces[MOST] = {{0, ARENA}};
static size_t count = 1, code;

static void *from(size_t piece, size_t bytes)
{
    bytes = (bytes + 15) & ~(size_t)15;
    if (pieces[piece].end - pieces[piece].begin < bytes)
        return NULL;
    pieces[piece].begin += bytes;
    return arena + pieces[piece].begin - bytes;
}

static size_t data_pieces(void)
{
    return count > 1 ? count - 1 : count;
}

static void *take(size_t bytes)
{
    void *found = NULL;
    for (size_t piece = 0; piece < data_pieces() && !found; piece++)
        found = from(piece, bytes);
    return found;
}

size_t gc_get_max_new_split(void)
{
    size_t most = 0;
    for (size_t piece = 0; piece < data_pieces(); piece++)
        most = MAX(most, pieces[piece].end - pieces[piece].begin);
    return most & ~(size_t)15;
}

void *chip_heap(size_t bytes)
{
    return take(bytes);
}

void *chip_commit(void *machine_code, size_t bytes, void *relocations)
{
    void *at = from(count - 1, bytes);
    if (!at)
        at = take(bytes);
    if (!at)
        m_malloc_fail(bytes);
    code += bytes;
    if (relocations)
        mp_native_relocate(relocations, machine_code, (uintptr_t)at);
    memcpy(at, machine_code, bytes);
    return at;
}

static mp_obj_t set_pieces(size_t n, const mp_obj_t *sizes)
{
    size_t at = pieces[0].begin;
    count = MIN(n, MOST);
    for (size_t piece = 0; piece < count; piece++) {
        at = (at + 15) & ~(size_t)15;
        pieces[piece].begin = at;
        pieces[piece].end = at += mp_obj_get_int(sizes[piece]);
    }
    return mp_const_none;
}
static MP_DEFINE_CONST_FUN_OBJ_VAR(pieces_obj, 2, set_pieces);

static mp_obj_t take_bytes(mp_obj_t bytes)
{
    return mp_obj_new_bool(take(mp_obj_get_int(bytes)) != NULL);
}
static MP_DEFINE_CONST_FUN_OBJ_1(take_obj, take_bytes);

static mp_obj_t left(void)
{
    mp_obj_t found[MOST];
    for (size_t piece = 0; piece < count; piece++)
        found[piece] = mp_obj_new_int(pieces[piece].end - pieces[piece].begin);
    return mp_obj_new_tuple(count, found);
}
static MP_DEFINE_CONST_FUN_OBJ_0(left_obj, left);

static mp_obj_t code_bytes(void)
{
    return mp_obj_new_int(code);
}
static MP_DEFINE_CONST_FUN_OBJ_0(code_obj, code_bytes);

static const mp_rom_map_elem_t globals_table[] = {
    {MP_ROM_QSTR(MP_QSTR___name__), MP_ROM_QSTR(MP_QSTR_chip)},
    {MP_ROM_QSTR(MP_QSTR_pieces), MP_ROM_PTR(&pieces_obj)},
    {MP_ROM_QSTR(MP_QSTR_take), MP_ROM_PTR(&take_obj)},
    {MP_ROM_QSTR(MP_QSTR_left), MP_ROM_PTR(&left_obj)},
    {MP_ROM_QSTR(MP_QSTR_code), MP_ROM_PTR(&code_obj)},
};
static MP_DEFINE_CONST_DICT(globals, globals_table);

const mp_obj_module_t chip_module = {
    .base = {&mp_type_module},
    .globals = (mp_obj_dict_t *)&globals,
};

MP_REGISTER_MODULE(MP_QSTR_chip, chip_module);
