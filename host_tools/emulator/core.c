/* A Cortex-M0+ for what needs nothing but registers, memories, divider, spinlocks and the timer's count, with a model of the flash cache.
 *
 * core_run() works on rp2040py's own registers and memories until `budget` cycles are spent, or an instruction comes that
 * is not its own: one that touches a peripheral, returns from an exception, sleeps, or may let an interrupt in. That one
 * it leaves undone, for rp2040py. Cycles are those that rp2040py counts; what the flash cache misses comes on top.
 * Compiled by native.py, whose structure has these fields in this order.
 */

#include <stdint.h>

typedef uint32_t u32;

enum { SPENT, NOT_MINE, UNALIGNED, NOT_THUMB, UNDEFINED }; /* why core_run() ends */
enum { ROM_BYTES = 0x4000, RAM_BYTES = 264 * 1024, FLASH_BYTES = 1 << 24, SETS = 1024 };
enum { NO_ALLOCATION = 1 << 24, NO_LOOK_UP = 1 << 25 }; /* bits of a flash address */
enum { FLASH_SLOTS = 1 << 20, RAM_SLOTS = RAM_BYTES / 2 }; /* of the profile: a slot is a halfword of code */
#define RAM 0x20000000u
#define SIO 0xD0000000u
#define SPINLOCKS 0x100u
#define TIMER_HIGH 0x40054024u /* TIMERAWH, and TIMERAWL behind it */
#define VALID 0x80000000u

typedef struct {
    u32 *r;
    uint8_t *ram, *flash, *rom;
    uint64_t *profile[2]; /* of threads and of handlers, or null: of each slot, cycles, and those of them for flash */
    u32 *touched; /* accesses of each line of the flash, or null */
    int64_t cycles;
    uint64_t accesses, misses;
    u32 fault;
    u32 miss_cycles, disabled, random;
    u32 dividend, divisor, quotient, remainder, csr, spinlocks;
    u32 event; /* whether there was a SEV */
    double timer_ns, cycle_ns; /* what the timer has counted as core_run() begins */
    u32 tags[SETS][2]; /* of each set, the line used last first */
} Core;

static void __attribute__((noinline)) miss(Core *core, u32 address, u32 *way, u32 tag)
{
    core->misses++;
    core->cycles += core->miss_cycles;
    if (core->disabled || address & NO_ALLOCATION)
        return;
    if (core->random) {
        core->random = core->random * 1664525u + 1013904223u | 1u;
        if (core->random & 0x10000u) {
            way[1] = tag;
            return;
        }
    } else
        way[1] = way[0];
    way[0] = tag;
}

/* An access to flash by any of its four addresses. */
static inline void touch(Core *core, u32 address)
{
    u32 line = (address & FLASH_BYTES - 1) >> 3, tag = line | VALID;
    u32 *way = core->tags[line & SETS - 1];

    core->accesses++;
    if (__builtin_expect(core->touched != 0, 0))
        core->touched[line]++;
    if (__builtin_expect(address & NO_LOOK_UP || core->disabled, 0))
        miss(core, address, way, tag);
    else if (__builtin_expect(way[0] != tag, 0)) {
        if (way[1] == tag) {
            way[1] = way[0];
            way[0] = tag;
        } else
            miss(core, address, way, tag);
    }
}

static inline int is_flash(u32 address)
{
    return address >> 26 == 0x10000000u >> 26;
}

/* The memory that `bytes` at an address lie in, or null. */
static inline uint8_t *readable(Core *core, u32 address, u32 bytes)
{
    if (address - RAM <= RAM_BYTES - bytes)
        return core->ram + (address - RAM);
    if (is_flash(address) && (address & FLASH_BYTES - 1) <= FLASH_BYTES - bytes) {
        touch(core, address);
        return core->flash + (address & FLASH_BYTES - 1);
    }
    if (address <= ROM_BYTES - bytes)
        return core->rom + address;
    return 0;
}

static inline uint8_t *writable(Core *core, u32 address, u32 bytes)
{
    return address - RAM <= RAM_BYTES - bytes ? core->ram + (address - RAM) : 0;
}

static void divide(Core *core, int is_signed)
{
    u32 a = core->dividend, b = core->divisor;

    if (!b) {
        core->quotient = is_signed && a >> 31 ? 1 : ~0u;
        core->remainder = a;
    } else if (is_signed) {
        core->quotient = (u32)((int64_t)(int32_t)a / (int32_t)b);
        core->remainder = (u32)((int64_t)(int32_t)a % (int32_t)b);
    } else {
        core->quotient = a / b;
        core->remainder = a % b;
    }
    core->csr = 3;
}

/* What of SIO belongs to the processor alone: its number, spinlocks, divider. */
static int sio_read(Core *core, u32 address, u32 *value)
{
    u32 place = address - SIO, lock = 1u << (place >> 2 & 31);

    if (place >> 7 == SPINLOCKS >> 7) {
        *value = core->spinlocks & lock ? 0 : lock;
        core->spinlocks |= lock;
        return 1;
    }
    switch (place) {
    case 0x00: *value = 0; return 1;
    case 0x5C: *value = core->spinlocks; return 1;
    case 0x60: case 0x68: *value = core->dividend; return 1;
    case 0x64: case 0x6C: *value = core->divisor; return 1;
    case 0x70: *value = core->quotient; core->csr &= ~2u; return 1;
    case 0x74: *value = core->remainder; return 1;
    case 0x78: *value = core->csr; return 1;
    }
    return 0;
}

static int sio_write(Core *core, u32 address, u32 value)
{
    u32 place = address - SIO;

    if (place >> 7 == SPINLOCKS >> 7) {
        core->spinlocks &= ~(1u << (place >> 2 & 31));
        return 1;
    }
    switch (place) {
    case 0x60: case 0x68: core->dividend = value; divide(core, place & 8); return 1;
    case 0x64: case 0x6C: core->divisor = value; divide(core, place & 8); return 1;
    case 0x70: core->quotient = value; core->csr = 3; return 1;
    case 0x74: core->remainder = value; core->csr = 3; return 1;
    }
    return 0;
}

/* The timer's microseconds, which the firmware looks at all the time; reading them changes nothing. */
static int timer_read(Core *core, u32 address, u32 *value)
{
    uint64_t us;

    if (address - TIMER_HIGH > 4)
        return 0;
    us = (uint64_t)((core->timer_ns + (double)core->cycles * core->cycle_ns) / 1000.0);
    *value = (u32)(address == TIMER_HIGH ? us >> 32 : us);
    return 1;
}

static uint64_t *slot(Core *core, u32 pc, int handler)
{
    uint64_t *profile = core->profile[handler];

    if (is_flash(pc))
        return profile + 2 * ((pc & FLASH_BYTES - 1) / 2 & FLASH_SLOTS - 1);
    if (pc - RAM < RAM_BYTES)
        return profile + 2 * (FLASH_SLOTS + (pc - RAM) / 2);
    return profile + 2 * (FLASH_SLOTS + RAM_SLOTS + pc / 2 % (ROM_BYTES / 2));
}

#define LOAD(type, at, into) do { \
    u32 address = (at); \
    if (address & sizeof(type) - 1) { core->fault = address; why = UNALIGNED; goto out; } \
    uint8_t *memory = readable(core, address, sizeof(type)); \
    if (memory) { into = (u32)*(type *)memory; spent = 2; } \
    else if (sizeof(type) == 4 && sio_read(core, address, &into)) spent = 1; \
    else if (address == SIO) into = 0, spent = 1; /* the processor's number, as a byte */ \
    else if (sizeof(type) == 4 && timer_read(core, address, &into)) spent = 4; \
    else goto not_mine; \
} while (0)

#define STORE(type, at, value) do { \
    u32 address = (at); \
    if (address & sizeof(type) - 1) { core->fault = address; why = UNALIGNED; goto out; } \
    uint8_t *memory = writable(core, address, sizeof(type)); \
    if (memory) { *(type *)memory = (type)(value); spent = 2; } \
    else if (sizeof(type) == 4 && sio_write(core, address, value)) spent = 1; \
    else goto not_mine; \
} while (0)

#define RESULT(value) (negative = zero = (value))
#define LOW(shift) (opcode >> (shift) & 7)

/* `a + b + carry in`, with all flags; a subtraction adds the complement. */
#define ADD_FLAGS(into, a, b, carry_in) do { \
    u32 left = (a), right = (b); \
    uint64_t wide = (uint64_t)left + right + (carry_in); \
    u32 sum = (u32)wide; \
    carry = wide >> 32; \
    overflow = (left ^ sum) & (right ^ sum); \
    into = RESULT(sum); \
} while (0)

/* `state` is APSR's flags, IPSR in bits 8…13, handler mode in bit 1, PRIMASK in bit 0. Returned: the same, with the reason
 * in bits 2…4; core->cycles is what was spent. */
u32 core_run(Core *core, int64_t budget, u32 state)
{
    u32 *r = core->r;
    u32 pc = r[15] & ~1u;
    u32 negative = state, zero = ~state >> 30 & 1, carry = state >> 29 & 1, overflow = state << 3;
    u32 masked = state & 1, masked_before = masked, handler = state >> 1 & 1, ipsr = state >> 8 & 0x3F;
    u32 why = SPENT, unused __attribute__((unused));
    int profiling = core->profile[ipsr != 0] != 0;
    u32 opcode, second, spent;

    core->cycles = 0;
    do {
        int64_t begun = core->cycles;
        u32 here = pc;
        uint8_t *code;

        if (is_flash(pc)) {
            touch(core, pc);
            code = core->flash + (pc & FLASH_BYTES - 1);
        } else if (pc - RAM < RAM_BYTES)
            code = core->ram + (pc - RAM);
        else if (pc < ROM_BYTES)
            code = core->rom + pc;
        else
            goto not_mine;
        opcode = *(uint16_t *)code;
        pc += 2;
        spent = 1;

        switch (opcode >> 8) {
        case 0x00 ... 0x07: { /* LSLS, MOVS between registers */
            u32 count = opcode >> 6 & 31, value = r[LOW(3)];
            if (count)
                carry = value >> (32 - count) & 1;
            r[LOW(0)] = RESULT(value << count);
            break;
        }
        case 0x08 ... 0x0F: { /* LSRS */
            u32 count = opcode >> 6 & 31, value = r[LOW(3)];
            carry = value >> (count ? count - 1 : 31) & 1;
            r[LOW(0)] = RESULT(count ? value >> count : 0);
            break;
        }
        case 0x10 ... 0x17: { /* ASRS */
            u32 count = opcode >> 6 & 31;
            int32_t value = (int32_t)r[LOW(3)];
            carry = value >> (count ? count - 1 : 31) & 1;
            r[LOW(0)] = RESULT((u32)(value >> (count ? count : 31)));
            break;
        }
        case 0x18: case 0x19: ADD_FLAGS(r[LOW(0)], r[LOW(3)], r[LOW(6)], 0); break;
        case 0x1A: case 0x1B: ADD_FLAGS(r[LOW(0)], r[LOW(3)], ~r[LOW(6)], 1); break;
        case 0x1C: case 0x1D: ADD_FLAGS(r[LOW(0)], r[LOW(3)], LOW(6), 0); break;
        case 0x1E: case 0x1F: ADD_FLAGS(r[LOW(0)], r[LOW(3)], ~LOW(6), 1); break;
        case 0x20 ... 0x27: r[LOW(8)] = RESULT(opcode & 0xFF); break;
        case 0x28 ... 0x2F: ADD_FLAGS(unused, r[LOW(8)], ~(opcode & 0xFF), 1); break;
        case 0x30 ... 0x37: ADD_FLAGS(r[LOW(8)], r[LOW(8)], opcode & 0xFF, 0); break;
        case 0x38 ... 0x3F: ADD_FLAGS(r[LOW(8)], r[LOW(8)], ~(opcode & 0xFF), 1); break;
        case 0x40 ... 0x43: { /* two low registers */
            u32 *d = r + LOW(0), m = r[LOW(3)], count = m & 0xFF;
            switch (opcode >> 6 & 15) {
            case 0: *d = RESULT(*d & m); break;
            case 1: *d = RESULT(*d ^ m); break;
            case 2: /* LSLS */
                if (count)
                    carry = count <= 32 ? *d >> (32 - count) & 1 : 0;
                *d = RESULT(count < 32 ? *d << count : 0);
                break;
            case 3: /* LSRS */
                if (count)
                    carry = count <= 32 ? *d >> (count - 1) & 1 : 0;
                *d = RESULT(count < 32 ? *d >> count : 0);
                break;
            case 4: /* ASRS */
                if (count)
                    carry = (u32)((int32_t)*d >> (count <= 32 ? count - 1 : 31)) & 1;
                *d = RESULT((u32)((int32_t)*d >> (count < 32 ? count : 31)));
                break;
            case 5: ADD_FLAGS(*d, *d, m, carry); break;
            case 6: ADD_FLAGS(*d, *d, ~m, carry); break;
            case 7: /* RORS */
                if (count) {
                    count &= 31;
                    RESULT(count ? *d >> count | *d << (32 - count) : *d);
                    *d = zero;
                    carry = *d >> 31;
                } else
                    RESULT(*d);
                break;
            case 8: RESULT(*d & m); break;
            case 9: ADD_FLAGS(*d, 0, ~m, 1); break;
            case 10: ADD_FLAGS(unused, *d, ~m, 1); break;
            case 11: ADD_FLAGS(unused, *d, m, 0); break;
            case 12: *d = RESULT(*d | m); break;
            case 13: *d = RESULT(*d * m); break;
            case 14: *d = RESULT(*d & ~m); break;
            case 15: *d = RESULT(~m); break;
            }
            break;
        }
        case 0x44: { /* ADD */
            u32 m = opcode >> 3 & 15, d = opcode >> 4 & 8 | opcode & 7;
            u32 sum = (d == 15 ? here + 4 : r[d]) + (m == 15 ? here + 4 : r[m]);
            if (d == 15) {
                pc = sum & ~1u;
                spent = 2;
            } else
                r[d] = d == 13 ? sum & ~3u : sum;
            break;
        }
        case 0x45: { /* CMP */
            u32 m = opcode >> 3 & 15, d = opcode >> 4 & 8 | opcode & 7;
            if (m == 15 || d == 15)
                goto not_mine;
            ADD_FLAGS(unused, r[d], ~r[m], 1);
            break;
        }
        case 0x46: { /* MOV */
            u32 m = opcode >> 3 & 15, d = opcode >> 4 & 8 | opcode & 7;
            u32 value = m == 15 ? here + 4 : r[m];
            if (d == 15) {
                pc = value & ~1u;
                spent = 2;
            } else
                r[d] = d == 13 ? value & ~3u : value;
            break;
        }
        case 0x47: { /* BX, BLX */
            u32 m = opcode >> 3 & 15, target = m == 15 ? here + 4 : r[m];
            if (opcode & 7 || handler && target >> 28 == 15 && !(opcode & 0x80))
                goto not_mine;
            if (!(target & 1)) {
                core->fault = target;
                why = NOT_THUMB;
                goto out;
            }
            if (opcode & 0x80)
                r[14] = pc | 1;
            pc = target & ~1u;
            spent = 2;
            break;
        }
        case 0x48 ... 0x4F: LOAD(u32, (here + 4 & ~3u) + (opcode & 0xFF) * 4, r[LOW(8)]); break;
        case 0x50: case 0x51: STORE(u32, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x52: case 0x53: STORE(uint16_t, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x54: case 0x55: STORE(uint8_t, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x56: case 0x57: LOAD(int8_t, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x58: case 0x59: LOAD(u32, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x5A: case 0x5B: LOAD(uint16_t, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x5C: case 0x5D: LOAD(uint8_t, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x5E: case 0x5F: LOAD(int16_t, r[LOW(3)] + r[LOW(6)], r[LOW(0)]); break;
        case 0x60 ... 0x67: STORE(u32, r[LOW(3)] + (opcode >> 6 & 31) * 4, r[LOW(0)]); break;
        case 0x68 ... 0x6F: LOAD(u32, r[LOW(3)] + (opcode >> 6 & 31) * 4, r[LOW(0)]); break;
        case 0x70 ... 0x77: STORE(uint8_t, r[LOW(3)] + (opcode >> 6 & 31), r[LOW(0)]); break;
        case 0x78 ... 0x7F: LOAD(uint8_t, r[LOW(3)] + (opcode >> 6 & 31), r[LOW(0)]); break;
        case 0x80 ... 0x87: STORE(uint16_t, r[LOW(3)] + (opcode >> 6 & 31) * 2, r[LOW(0)]); break;
        case 0x88 ... 0x8F: LOAD(uint16_t, r[LOW(3)] + (opcode >> 6 & 31) * 2, r[LOW(0)]); break;
        case 0x90 ... 0x97: STORE(u32, r[13] + (opcode & 0xFF) * 4, r[LOW(8)]); break;
        case 0x98 ... 0x9F: LOAD(u32, r[13] + (opcode & 0xFF) * 4, r[LOW(8)]); break;
        case 0xA0 ... 0xA7: r[LOW(8)] = (here + 4 & ~3u) + (opcode & 0xFF) * 4; break;
        case 0xA8 ... 0xAF: r[LOW(8)] = r[13] + (opcode & 0xFF) * 4; break;
        case 0xB0: /* ADD and SUB of the stack pointer */
            r[13] = r[13] + (opcode & 0x80 ? -(opcode & 0x7F) : opcode & 0x7F) * 4 & ~3u;
            break;
        case 0xB2: {
            u32 m = r[LOW(3)];
            switch (opcode >> 6 & 3) {
            case 0: r[LOW(0)] = (u32)(int16_t)m; break;
            case 1: r[LOW(0)] = (u32)(int8_t)m; break;
            case 2: r[LOW(0)] = m & 0xFFFF; break;
            case 3: r[LOW(0)] = m & 0xFF; break;
            }
            break;
        }
        case 0xB4: case 0xB5: { /* PUSH */
            u32 count = (u32)__builtin_popcount(opcode & 0x1FF), i;
            u32 *to = (u32 *)writable(core, r[13] - 4 * count, 4 * count);
            if (!to)
                goto not_mine;
            for (i = 0; i < 8; i++)
                if (opcode >> i & 1) {
                    *to++ = r[i];
                    spent++;
                }
            if (opcode & 0x100)
                *to = r[14];
            r[13] -= 4 * count;
            break;
        }
        case 0xB6: /* CPSIE, CPSID */
            if (opcode == 0xB662 && !masked_before)
                masked = 0;
            else if (opcode == 0xB672)
                masked = 1;
            else
                goto not_mine;
            break;
        case 0xBA: {
            u32 m = r[LOW(3)];
            switch (opcode >> 6 & 3) {
            case 0: r[LOW(0)] = __builtin_bswap32(m); break;
            case 1: r[LOW(0)] = m >> 8 & 0x00FF00FF | m << 8 & 0xFF00FF00; break;
            case 3: r[LOW(0)] = (u32)(int16_t)__builtin_bswap16((uint16_t)m); break;
            default: goto not_mine;
            }
            break;
        }
        case 0xBC: case 0xBD: { /* POP */
            u32 count = (u32)__builtin_popcount(opcode & 0x1FF), i;
            u32 *from = (u32 *)writable(core, r[13], 4 * count);
            if (!from)
                goto not_mine;
            if (opcode & 0x100) {
                u32 target = from[count - 1];
                if (handler && target >> 28 == 15)
                    goto not_mine;
                if (!(target & 1)) {
                    core->fault = target;
                    why = NOT_THUMB;
                    goto out;
                }
                pc = target & ~1u;
                spent = 3;
            }
            for (i = 0; i < 8; i++)
                if (opcode >> i & 1) {
                    r[i] = *from++;
                    spent++;
                }
            r[13] += 4 * count;
            break;
        }
        case 0xBF: /* hints: all but NOP and SEV are rp2040py's */
            if (opcode == 0xBF40)
                core->event = 1;
            else if (opcode != 0xBF00)
                goto not_mine;
            break;
        case 0xC0 ... 0xC7: { /* STMIA */
            u32 n = LOW(8), count = (u32)__builtin_popcount(opcode & 0xFF), i, *to;
            if (r[n] & 3) {
                core->fault = r[n];
                why = UNALIGNED;
                goto out;
            }
            to = (u32 *)writable(core, r[n], 4 * count);
            if (!to)
                goto not_mine;
            for (i = 0; i < 8; i++)
                if (opcode >> i & 1)
                    *to++ = r[i];
            if (!(opcode >> n & 1))
                r[n] += 4 * count;
            spent += count;
            break;
        }
        case 0xC8 ... 0xCF: { /* LDMIA */
            u32 n = LOW(8), count = (u32)__builtin_popcount(opcode & 0xFF), address = r[n], i, *from;
            if (address & 3) {
                core->fault = address;
                why = UNALIGNED;
                goto out;
            }
            if (is_flash(address)) {
                if ((address & FLASH_BYTES - 1) > FLASH_BYTES - 32)
                    goto not_mine;
                for (i = 0; i < count; i++)
                    touch(core, address + 4 * i);
                from = (u32 *)(core->flash + (address & FLASH_BYTES - 1));
            } else
                from = (u32 *)readable(core, address, 4 * count);
            if (!from)
                goto not_mine;
            for (i = 0; i < 8; i++)
                if (opcode >> i & 1)
                    r[i] = *from++;
            if (!(opcode >> n & 1))
                r[n] = address + 4 * count;
            spent += count;
            break;
        }
        case 0xD0 ... 0xDD: {
            u32 taken;
            switch (opcode >> 9 & 7) {
            case 0: taken = !zero; break;
            case 1: taken = carry; break;
            case 2: taken = negative >> 31; break;
            case 3: taken = overflow >> 31; break;
            case 4: taken = carry && zero; break;
            case 5: taken = (negative ^ overflow) >> 31 ^ 1; break;
            default: taken = zero && !((negative ^ overflow) >> 31); break;
            }
            if (taken ^ opcode >> 8 & 1) {
                pc = here + 4 + (u32)((int32_t)(int8_t)opcode * 2);
                spent = 2;
            }
            break;
        }
        case 0xE0 ... 0xE7:
            pc = here + 4 + (u32)((int32_t)(opcode << 21) >> 20);
            spent = 2;
            break;
        case 0xF0 ... 0xF7: {
            if (is_flash(pc))
                touch(core, pc);
            second = *(uint16_t *)(code + 2);
            spent = 3;
            if ((second & 0xD000) == 0xD000) { /* BL */
                u32 s = opcode >> 10 & 1, j1 = second >> 13 & 1, j2 = second >> 11 & 1;
                u32 offset = (s ? 0xFF000000u : 0) | (s ^ j1 ^ 1) << 23 | (s ^ j2 ^ 1) << 22
                           | (opcode & 0x3FF) << 12 | (second & 0x7FF) << 1;
                r[14] = here + 4 | 1;
                pc = here + 4 + offset;
            } else if (opcode == 0xF3BF && ((second & 0xFFD0) == 0x8F40 || (second & 0xFFF0) == 0x8F50))
                pc += 2; /* DSB, ISB, DMB */
            else if (opcode == 0xF3EF && (second & 0xF0FF) == 0x8010) { /* MRS PRIMASK */
                r[second >> 8 & 15] = masked;
                pc += 2;
            } else if (opcode == 0xF3EF && (second & 0xF0FF) == 0x8005) { /* MRS IPSR */
                r[second >> 8 & 15] = ipsr;
                pc += 2;
            } else if ((opcode & 0xFFF0) == 0xF380 && second == 0x8810 && !masked_before) { /* MSR PRIMASK */
                masked = r[opcode & 15] & 1;
                pc += 2;
            } else
                goto not_mine;
            break;
        }
        case 0xE8 ... 0xEF:
        case 0xF8 ... 0xFF: /* erased flash, too */
            core->fault = here;
            why = UNDEFINED;
            goto out;
        default:
            goto not_mine;
        }
        core->cycles += spent;
        if (__builtin_expect(profiling, 0)) {
            uint64_t *at = slot(core, here, ipsr != 0);
            at[0] += (uint64_t)(core->cycles - begun);
            at[1] += (uint64_t)(core->cycles - begun - spent);
        }
        continue;

    not_mine:
        why = NOT_MINE;
    out:
        pc = here;
        if (profiling && (is_flash(pc) || pc - RAM < RAM_BYTES || pc < ROM_BYTES)) {
            uint64_t *at = slot(core, here, ipsr != 0);
            at[0] += (uint64_t)(core->cycles - begun);
            at[1] += (uint64_t)(core->cycles - begun);
        }
        break;
    } while (core->cycles < budget);

    r[15] = pc;
    return (negative & 0x80000000u) | (u32)!zero << 30 | (carry & 1) << 29 | overflow >> 31 << 28
         | why << 2 | (state & 0x3F02) | masked;
}

/* How large a Core is, for native.py to compare. */
u32 core_size(void)
{
    return sizeof(Core);
}
