/* Two files as a part of the executable: EMBEDDED_PACK and EMBEDDED_PROFILE. A pack begins on a boundary of 64 bytes. */
        .section .rodata
        .global pack_begin, pack_end, profile_begin, profile_end
        .balign 64
pack_begin:
        .incbin EMBEDDED_PACK
pack_end:
profile_begin:
        .incbin EMBEDDED_PROFILE
profile_end:
        .section .note.GNU-stack,"",%progbits
