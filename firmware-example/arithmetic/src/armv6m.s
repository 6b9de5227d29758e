@ Product, quotient, sum, difference and comparisons of f32 on an ARMv6-M core (Cortex-M0, M0+), with the bits of IEEE 754: to nearest and to even.
@ Of two operands that are not a number the bits of either may be kept.
@ What is not a normal number, or has no normal result, goes to the functions of the compiler, __mulsf3, __divsf3 and __addsf3; zeros of products and sums do not.
@ Arguments and results are bits in registers: r0, r1 in, r0 out; r2, r3 and r12 are free by the calling convention.

    .syntax unified
    .macro function name
    .global \name
    .type \name, %function
    .thumb_func
\name:
    .endm

    .macro unpack
    push {{r0, r1, r4, r5, r6, lr}}
    mov r4, r0
    eors r4, r1
    mov r12, r4                 @ sign
    lsls r2, r0, #1
    lsrs r2, r2, #24            @ exponent fields
    lsls r3, r1, #1
    lsrs r3, r3, #24
    subs r4, r2, #1
    cmp r4, #254
    bhs 5f
    subs r5, r3, #1
    cmp r5, #254
    bhs 5f
    .endm

    .section .text.harvester_fmul, "ax", %progbits
    .balign 4
    function __aeabi_fmul
    unpack
    adds r2, r4, r5
    @ Significands of 24 bits in parts of 16 and 8.
    uxtb r6, r0
    uxtb r4, r1
    movs r3, #1
    lsls r3, r3, #31
    lsls r0, r0, #8
    orrs r0, r3
    lsrs r0, r0, #16
    lsls r1, r1, #8
    orrs r1, r3
    lsrs r1, r1, #16
    mov r3, r0
    muls r3, r1, r3             @ high by high
    muls r0, r4, r0             @ high by low, twice
    muls r1, r6, r1
    muls r4, r6, r4             @ low by low
    adds r0, r0, r1
    lsrs r1, r4, #8
    adds r0, r0, r1
    uxtb r4, r4
    uxtb r1, r0
    orrs r4, r1                 @ r4: whether bits below those of r3 are set
    lsrs r0, r0, #8
    adds r3, r3, r0             @ r3: upper 32 of 48 bits
    bmi 1f
    adds r3, r3, r3
    subs r2, r2, #1
1:  subs r2, r2, #125           @ exponent field less 1: the leading bit adds it
    cmp r2, #253
    bhs 6f
    lsls r2, r2, #23
    lsrs r0, r3, #8             @ carry: the first bit below the result
    adcs r2, r0
    lsls r3, r3, #25            @ carry: the same bit
    orrs r3, r4
    beq 3f
2:  mov r0, r12
    lsrs r0, r0, #31
    lsls r0, r0, #31
    orrs r0, r2
    add sp, #8
    pop {{r4, r5, r6, pc}}
3:  bcc 2b                      @ exact
    movs r1, #1                 @ in the middle: to even
    bics r2, r1
    b 2b
5:  lsls r4, r0, #1             @ zero times what is finite
    bne 7f
    cmp r3, #255
    bne 8f
    b 6f
7:  lsls r4, r1, #1
    bne 6f
    cmp r2, #255
    beq 6f
8:  movs r2, #0
    b 2b
6:  ldr r0, [sp]
    ldr r1, [sp, #4]
    bl __mulsf3
    add sp, #8
    pop {{r4, r5, r6, pc}}
    .size __aeabi_fmul, . - __aeabi_fmul

    .section .text.harvester_fadd, "ax", %progbits
    .balign 4
    function __aeabi_fsub
    movs r2, #1
    lsls r2, r2, #31
    eors r1, r2
    function __aeabi_fadd
    push {{r4, r5, r6, lr}}
    lsls r2, r0, #1
    lsls r3, r1, #1
    cmp r2, r3
    bhs 1f
    mov r4, r0                  @ the larger one first
    mov r0, r1
    mov r1, r4
    mov r4, r2
    mov r2, r3
    mov r3, r4
1:  lsrs r4, r2, #24            @ exponent fields
    lsrs r5, r3, #24
    beq 7f
    cmp r4, #255
    beq 9f
    subs r5, r4, r5
    cmp r5, #25
    bhi 8f                      @ below half a unit in the last place
    mov r12, r1
    eors r1, r0                 @ sign: whether they differ
    movs r6, #1
    lsls r6, r6, #31
    lsls r2, r2, #7
    orrs r2, r6                 @ significands of 32 bits
    lsls r3, r3, #7
    orrs r3, r6
    movs r6, #32
    subs r6, r6, r5
    cmp r1, #0
    bmi 4f
    mov r1, r3
    lsls r1, r6                 @ what is shifted out
    lsrs r3, r5
    adds r2, r2, r3
    bcc 2f
    lsls r6, r2, #31
    orrs r1, r6
    lsrs r2, r2, #1
    adds r4, r4, #2             @ one for the leading bit, which is not in r2
2:  subs r4, r4, #1             @ exponent field less 1: the leading bit adds it
    cmp r4, #253
    bhs 6f
    lsls r4, r4, #23
    lsrs r3, r2, #8             @ carry: the first bit below the result
    adcs r4, r3
    lsls r2, r2, #25            @ carry: the same bit
    orrs r2, r1
    beq 5f
3:  lsrs r0, r0, #31
    lsls r0, r0, #31
    orrs r0, r4
8:  pop {{r4, r5, r6, pc}}
5:  bcc 3b                      @ exact
    movs r1, #1                 @ in the middle: to even
    bics r4, r1
    b 3b
4:  mov r1, r3
    lsls r1, r6
    lsrs r3, r5
    rsbs r1, r1, #0
    sbcs r2, r3
    bmi 2b
    beq 12f
    lsrs r3, r2, #24
    bne 11f
    lsls r2, r2, #8
    subs r4, #8
    lsrs r3, r2, #24
    bne 10f
    lsls r2, r2, #8
    subs r4, #8
10: cmp r2, #0
    bmi 2b
11: subs r4, r4, #1
    adds r2, r2, r2
    bpl 11b
    b 2b
12: movs r0, #0
    pop {{r4, r5, r6, pc}}
7:  cmp r3, #0                  @ the smaller one is zero, or below the normal numbers
    bne 9f
    cmp r4, #255
    beq 9f
    cmp r4, #0
    bne 8b
    cmp r2, #0
    bne 9f
    ands r0, r1                 @ two zeros
    pop {{r4, r5, r6, pc}}
6:  mov r1, r12
9:  bl __addsf3
    pop {{r4, r5, r6, pc}}
    .size __aeabi_fadd, . - __aeabi_fadd

    .section .text.harvester_fdiv, "ax", %progbits
    .balign 4
    function __aeabi_fdiv
    unpack
    subs r2, r2, r3
    adds r2, #126               @ exponent field less 1: the leading bit adds it
    movs r4, #1
    lsls r4, r4, #31
    lsls r0, r0, #8
    orrs r0, r4
    lsrs r0, r0, #8             @ significands m and d of 24 bits
    lsls r1, r1, #8
    orrs r1, r4
    lsrs r3, r1, #16            @ d to 16 bits, t
    lsrs r1, r1, #8
    cmp r0, r1
    bhs 1f
    adds r0, r0, r0             @ d <= m < 2 d
    subs r2, r2, #1
1:  lsrs r4, r3, #4             @ x, 2^31/t: a line within 7 %, two iterations of Newton, 2 less: not above 2^39/d
    subs r4, r4, r3
    movs r5, #180
    lsls r5, r5, #9
    adds r4, r4, r5
    .rept 2
    mov r5, r4; muls r5, r3, r5; rsbs r5, r5, #0; lsrs r5, r5, #16
    muls r4, r5, r4; lsrs r4, r4, #15
    .endr
    subs r4, r4, #2
    lsrs r5, r0, #9
    muls r5, r4, r5
    lsrs r5, r5, #18            @ upper digit of 12 bits and one
    mov r6, r5
    muls r6, r1, r6
    lsls r0, r0, #12
    subs r0, r0, r6
    lsrs r6, r0, #10
    muls r6, r4, r6
    lsrs r6, r6, #17            @ lower digit
    lsls r5, r5, #12
    adds r5, r5, r6
    muls r6, r1, r6
    lsls r0, r0, #12
    subs r0, r0, r6
    b 3f
2:  adds r5, r5, #1
    subs r0, r0, r1
3:  cmp r0, r1
    bhs 2b
    cmp r2, #253
    bhs 5f
    lsls r2, r2, #23
    lsrs r5, r5, #1             @ carry: the first bit below the result, which never lies in the middle
    adcs r2, r5
    mov r0, r12
    lsrs r0, r0, #31
    lsls r0, r0, #31
    orrs r0, r2
    add sp, #8
    pop {{r4, r5, r6, pc}}
5:  ldr r0, [sp]
    ldr r1, [sp, #4]
    bl __divsf3
    add sp, #8
    pop {{r4, r5, r6, pc}}
    .size __aeabi_fdiv, . - __aeabi_fdiv

    @ Of operands that are not below zero, of zeros, of one below zero, of both.
    .macro compare swapped, name, fails, zeros, holds, below
    .balign 4
    function \swapped
    mov r2, r0
    mov r0, r1
    mov r1, r2
    function \name
    movs r2, #255
    lsls r2, r2, #24
    lsls r3, r0, #1
    cmp r3, r2
    bhi 2f                      @ not a number
    lsls r3, r1, #1
    cmp r3, r2
    bhi 2f
    mov r2, r0
    orrs r2, r1
    bmi 3f
    cmp r0, r1
    b\fails 2f
1:  movs r0, #1
    bx lr
2:  movs r0, #0
    bx lr
3:  lsls r2, r2, #1
    beq \zeros                  @ two zeros
    mov r2, r0
    ands r2, r1
    bmi 4f
    cmp r0, r1
    b\holds 1b
    b 2b
4:  cmp r0, r1                  @ two numbers below zero
    b\below 1b
    b 2b
    .size \name, . - \name
    .endm

    .section .text.harvester_fcmp, "ax", %progbits
    compare __aeabi_fcmpgt, __aeabi_fcmplt, ge, 2b, lt, gt
    compare __aeabi_fcmpge, __aeabi_fcmple, gt, 1b, le, ge
