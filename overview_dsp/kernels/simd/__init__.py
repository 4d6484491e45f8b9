"""SIMD processing of several voices, one in each lane of a vector."""
