/* What kernel.c is written in: memory, lanes and integers as the kernels use them. */
#ifndef OVERVIEW_OPERATIONS_H
#define OVERVIEW_OPERATIONS_H

/* Whatever lets a compiler change the arithmetic changes the sound. What it tells in no macro is
   found by the self-test in overview_load. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) \
    || defined(__NO_SIGNED_ZEROS__) || defined(_M_FP_FAST) \
    || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "overView: -ffast-math, -Ofast, /fp:fast and their parts change the sound. \
Compile kernel.c without them, or with -fno-fast-math after them."
#endif
#if defined(__FLT_EVAL_METHOD__)
#if __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error "overView: x87 arithmetic changes the sound. Compile kernel.c with -msse2 -mfpmath=sse."
#endif
#endif
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "overView: kernel.c is for little-endian machines."
#endif
typedef char overview_not_with_fsingle_precision_constant[sizeof(1.0) == 8 ? 1 : -1];

#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef struct { double v[8]; } ov_lanes;

#define OV_ACCESS(letter, type) \
    static inline type ov_load_##letter(const unsigned char *p) { \
        type x; memcpy(&x, p, sizeof x); return x; } \
    static inline void ov_store_##letter(unsigned char *p, type x) { memcpy(p, &x, sizeof x); }
OV_ACCESS(b, uint8_t)
OV_ACCESS(i, uint32_t)
OV_ACCESS(l, uint64_t)
OV_ACCESS(d, double)
OV_ACCESS(f, float)
OV_ACCESS(p, unsigned char *)
OV_ACCESS(v, ov_lanes)

/* Counts of the queues between threads, at addresses of 8 bytes; OV_GET and OV_SET for one flag. */
#if defined(__GCC_ATOMIC_LLONG_LOCK_FREE) && __GCC_ATOMIC_LLONG_LOCK_FREE == 2
typedef uint64_t __attribute__((may_alias, aligned(8))) ov_word;
static inline uint64_t ov_acquire_l(const unsigned char *p) {
    return __atomic_load_n((const ov_word *)p, __ATOMIC_ACQUIRE); }
static inline void ov_release_l(unsigned char *p, uint64_t x) {
    __atomic_store_n((ov_word *)p, x, __ATOMIC_RELEASE); }
#define OV_GET(place) __atomic_load_n(place, __ATOMIC_RELAXED)
#define OV_SET(place, value) __atomic_store_n(place, value, __ATOMIC_RELAXED)
#elif defined(__GCC_ATOMIC_INT_LOCK_FREE) /* no word of 8 bytes at once: fences beside it */
static inline uint64_t ov_acquire_l(const unsigned char *p) {
    uint64_t x = ov_load_l(p); __atomic_thread_fence(__ATOMIC_ACQUIRE); return x; }
static inline void ov_release_l(unsigned char *p, uint64_t x) {
    __atomic_thread_fence(__ATOMIC_RELEASE); ov_store_l(p, x); }
#define OV_GET(place) __atomic_load_n(place, __ATOMIC_RELAXED)
#define OV_SET(place, value) __atomic_store_n(place, value, __ATOMIC_RELAXED)
#elif !defined(__cplusplus) && defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L \
    && !defined(__STDC_NO_ATOMICS__)
#include <stdatomic.h>
static inline uint64_t ov_acquire_l(const unsigned char *p) {
    return atomic_load_explicit((_Atomic uint64_t *)(uintptr_t)p, memory_order_acquire); }
static inline void ov_release_l(unsigned char *p, uint64_t x) {
    atomic_store_explicit((_Atomic uint64_t *)(uintptr_t)p, x, memory_order_release); }
#define OV_GET(place) atomic_load_explicit((_Atomic int32_t *)(place), memory_order_relaxed)
#define OV_SET(place, value) \
    atomic_store_explicit((_Atomic int32_t *)(place), value, memory_order_relaxed)
#else /* for one thread; on x86, whose loads and stores keep their order, for several: a compiler
         without C11 does not move them past volatile ones */
static inline uint64_t ov_acquire_l(const unsigned char *p) {
    return *(const volatile uint64_t *)(const void *)p; }
static inline void ov_release_l(unsigned char *p, uint64_t x) {
    *(volatile uint64_t *)(void *)p = x; }
#define OV_GET(place) (*(volatile int32_t *)(place))
#define OV_SET(place, value) (*(volatile int32_t *)(place) = (value))
#endif

#define OV_LANES(name, operator) \
    static inline ov_lanes ov_##name(ov_lanes a, ov_lanes b) { \
        ov_lanes x; int i; for (i = 0; i < 8; i++) x.v[i] = a.v[i] operator b.v[i]; return x; }
OV_LANES(add, +)
OV_LANES(sub, -)
OV_LANES(mul, *)
static inline ov_lanes ov_splat(double a) {
    ov_lanes x; int i; for (i = 0; i < 8; i++) x.v[i] = a; return x; }
static inline uint64_t ov_smax(uint64_t a, uint64_t b) { return (int64_t)a > (int64_t)b ? a : b; }
static inline uint64_t ov_smin(uint64_t a, uint64_t b) { return (int64_t)a < (int64_t)b ? a : b; }
static inline uint64_t ov_umax(uint64_t a, uint64_t b) { return a > b ? a : b; }
static inline uint64_t ov_umin(uint64_t a, uint64_t b) { return a < b ? a : b; }
static inline uint32_t ov_smax32(uint32_t a, uint32_t b) {
    return (int32_t)a > (int32_t)b ? a : b; }
static inline uint64_t ov_bits(double x) { uint64_t b; memcpy(&b, &x, 8); return b; }
static inline double ov_double(uint64_t b) { double x; memcpy(&x, &b, 8); return x; }

#endif
