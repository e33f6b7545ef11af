// Of late_gdal.cpp: a jump a function, through a table that load_gdal() fills.
#if defined(__x86_64__)
#define JUMP jmp *1b(%rip)
#elif defined(__aarch64__)
#define JUMP adrp x16, 1b; ldr x16, [x16, :lo12:1b]; br x16
#else
#error "add this processor's jump"
#endif
#define FUNCTION(name) .data; 1: .quad fjell_gdal_missing; .text; .globl name; .hidden name; .type name, %function; name: JUMP
#define TYPEINFO(name) .data; .globl name; .hidden name; name: .skip 24

.data
.balign 8
.globl fjell_gdal_table
.hidden fjell_gdal_table
fjell_gdal_table:
#include "gdal_names.inc"
.section .note.GNU-stack, "", %progbits
