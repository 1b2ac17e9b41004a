/* Names that other headers define as macros: those of <windows.h>, <math.h> and <complex.h> that
   people meet. The header has none of them. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#undef DOMAIN
#undef I
#undef OVERFLOW
#undef UNDERFLOW
#undef max
#undef min
#define near
#define far
#define NEAR
#define FAR
#define pascal
#define cdecl
#define small     char
#define hyper     int
#define byte      unsigned char
#define boolean   unsigned char
#define interface struct
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define abs(a)    ((a) < 0 ? -(a) : (a))
#define complex   _Complex
#define imaginary _Imaginary
#define I         1.0iF
#define DOMAIN    1
#define SING      2
#define OVERFLOW  3
#define UNDERFLOW 4
#define PLOSS     6
#define IN
#define OUT
#define OPTIONAL
#define CONST     const
#define VOID      void
#define TRUE      1
#define FALSE     0
#define ERROR     0
#define IGNORE    0
#define DELETE    0x10000
#define STRICT    1
#define TRANSPARENT 1
#define OPAQUE    2
#define ABSOLUTE  1
#define RELATIVE  2
#define rad1      1
#define grp1      2
#define unix      1
#define linux     1
#define B0        0

#include "sss_resample.h"

typedef int not_empty;
