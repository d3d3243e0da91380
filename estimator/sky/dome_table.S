// dome_table.bin as part of the program.
        .section .rodata
        .balign 16
        .global kasumi_dome_table
        .type kasumi_dome_table, %object
kasumi_dome_table:
        .incbin KASUMI_DOME_TABLE
kasumi_dome_table_end:
        .size kasumi_dome_table, . - kasumi_dome_table
        .balign 4
        .global kasumi_dome_table_bytes
        .type kasumi_dome_table_bytes, %object
        .size kasumi_dome_table_bytes, 4
kasumi_dome_table_bytes:
        .long kasumi_dome_table_end - kasumi_dome_table
        .section .note.GNU-stack, "", %progbits
