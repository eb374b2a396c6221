/* Starts digests.c on an x86-64 processor that has nothing but memory, a serial port and this program as its ROM: neither firmware
 * nor an operating system. From reset to 64 bits with AVX-512 enabled, as Intel's manual (volume 3, chapters 9 and 13) asks. */

.set SIZE, 0x100000                     /* of the ROM, which ends at 4 GiB; it is copied to 1 MiB */
.set ROM, 0x100000000 - SIZE
.set COPY, 0x100000

/* Where the processor starts, 16 bytes below the end, in 16 bits; addresses there count from 64 KiB below the end. */
        .section .reset, "ax"
        .code16
        .globl  reset
reset:  cli
        lgdtl   %cs:(table_size - reset + 0xff00)
        movl    $0x11, %eax             /* CR0: protected mode */
        movl    %eax, %cr0
        ljmpl   $8, $(copy + ROM - COPY)

        .code32
copy:   movw    $16, %ax
        movw    %ax, %ds
        movw    %ax, %es
        movw    %ax, %ss
        cld
        movl    $ROM, %esi
        movl    $COPY, %edi
        movl    $(SIZE / 4), %ecx
        rep movsl
        movl    $paging, %eax
        jmp     *%eax

        .balign 8
table:  .quad   0
        .quad   0x00cf9a000000ffff      /* 8: code of 32 bits */
        .quad   0x00cf92000000ffff      /* 16: data */
        .quad   0x00af9a000000ffff      /* 24: code of 64 bits */
table_size:
        .word   table_size - table - 1
        .long   table + ROM - COPY
copied_size:
        .word   table_size - table - 1
        .long   table

        .org    0xf0
        .code16
        jmp     reset
        .org    0x100

/* The first GiB at its own addresses, in pages of 2 MiB; then 64 bits. RAM is zero at the start. */
        .text
        .code32
paging: lgdtl   copied_size             /* the table in ROM will be out of sight */
        movl    $(tables + 0x1003), tables
        movl    $(tables + 0x2003), tables + 0x1000
        movl    $tables + 0x2000, %edi
        movl    $0x83, %eax
        movl    $512, %ecx
page:   movl    %eax, (%edi)
        addl    $0x200000, %eax
        addl    $8, %edi
        loop    page
        movl    $tables, %eax
        movl    %eax, %cr3
        movl    $0x40620, %eax          /* CR4: long pages, SSE and its exceptions, extended state */
        movl    %eax, %cr4
        movl    $0xc0000080, %ecx       /* EFER: 64 bits */
        movl    $0x100, %eax
        xorl    %edx, %edx
        wrmsr
        movl    $0x80000033, %eax       /* CR0: paging, floating point */
        movl    %eax, %cr0
        ljmp    $24, $start

        .code64
start:  movl    $13, %eax               /* XCR0: of x87, SSE, AVX and AVX-512 what the processor has */
        xorl    %ecx, %ecx
        cpuid
        andl    $0xe7, %eax
        xorl    %ecx, %ecx
        xorl    %edx, %edx
        xsetbv
        movl    $stack_top, %esp
        call    main
stay:   hlt
        jmp     stay

        .section .note.GNU-stack, "", @progbits
