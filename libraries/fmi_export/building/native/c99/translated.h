/* What kernels translated from LLVM assembly to C (translation.py) are written with.

   An integer is unsigned, so that it wraps around; operations on signed ones say so. An address is a number of 64
   bits in variables and in memory, whatever the target has, so that offsets are the same everywhere. Memory is read
   and written by memcpy, which compilers turn into a load or store: no alignment and no type of the data is assumed. */

#ifndef AMB_TRANSLATED_H
#define AMB_TRANSLATED_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* A product and a sum are rounded apart. GCC does not know the pragma; it does so with -std=c99 or
   -ffp-contract=off. */
#if defined __clang__ || !defined __GNUC__
#pragma STDC FP_CONTRACT OFF
#endif

typedef uint64_t address;

#define TO_POINTER(at) ((void *)(uintptr_t)(at))
#define TO_ADDRESS(pointer) ((address)(uintptr_t)(pointer))

#define MEMORY(type, name)                                                                                             \
    static inline type load_##name(address at)                                                                         \
    {                                                                                                                  \
        type value;                                                                                                    \
        memcpy(&value, TO_POINTER(at), sizeof value);                                                                  \
        return value;                                                                                                  \
    }                                                                                                                  \
    static inline void store_##name(address at, type value) { memcpy(TO_POINTER(at), &value, sizeof value); }

MEMORY(double, double)
MEMORY(uint64_t, i64)
MEMORY(uint32_t, i32)
MEMORY(uint16_t, i16)
MEMORY(uint8_t, i8)

/* The double with these bits: what is not a number has no constant in C. */
static inline double from_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline uint64_t to_bits(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* A number without its fraction; where that does not fit, which C leaves open, the lowest integer, as x86 has it. */
static inline uint64_t to_signed(double x)
{
    return x >= -0x1p63 && x < 0x1p63 ? (uint64_t)(int64_t)x : (uint64_t)1 << 63;
}

static inline uint64_t to_unsigned(double x) { return x > -1.0 && x < 0x1p64 ? (uint64_t)x : 0; }

/* How many of the lowest `width` bits are zero before the highest bit set, and after the lowest. */
static inline uint64_t leading_zeros(uint64_t x, uint64_t width)
{
    uint64_t count = 0;
    while (count < width && !(x >> (width - 1 - count) & 1))
        count++;
    return count;
}

static inline uint64_t trailing_zeros(uint64_t x, uint64_t width)
{
    uint64_t count = 0;
    while (count < width && !(x >> count & 1))
        count++;
    return count;
}

static inline uint64_t count_ones(uint64_t x)
{
    uint64_t count = 0;
    for (; x; x &= x - 1)
        count++;
    return count;
}

#endif
