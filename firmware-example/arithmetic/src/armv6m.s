@ Product, sum, difference and comparisons of f32 on an ARMv6-M core (Cortex-M0, M0+), with the bits of IEEE 754: to nearest and to even.
@ Of two operands that are not a number the bits of either may be kept.
@ What is not a normal number, or has no normal result, goes to the functions of the compiler, __mulsf3 and __addsf3; zeros do not.
@ Arguments and results are bits in registers: r0, r1 in, r0 out; r2, r3 and r12 are free by the calling convention.

    .syntax unified
    .section .text.harvester_fmul, "ax", %progbits
    .balign 4
    .global __aeabi_fmul
    .type __aeabi_fmul, %function
    .thumb_func
__aeabi_fmul:
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
    .global __aeabi_fsub
    .type __aeabi_fsub, %function
    .thumb_func
__aeabi_fsub:
    movs r2, #1
    lsls r2, r2, #31
    eors r1, r2
    .global __aeabi_fadd
    .type __aeabi_fadd, %function
    .thumb_func
__aeabi_fadd:
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

    .section .text.harvester_fcmp, "ax", %progbits
    .balign 4
    .global __aeabi_fcmpgt
    .type __aeabi_fcmpgt, %function
    .thumb_func
__aeabi_fcmpgt:
    mov r2, r0
    mov r0, r1
    mov r1, r2
    .global __aeabi_fcmplt
    .type __aeabi_fcmplt, %function
    .thumb_func
__aeabi_fcmplt:
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
    bge 2f
1:  movs r0, #1
    bx lr
2:  movs r0, #0
    bx lr
3:  lsls r2, r2, #1
    beq 2b                      @ two zeros
    mov r2, r0
    ands r2, r1
    bmi 4f
    cmp r0, r1
    blt 1b
    b 2b
4:  cmp r0, r1                  @ two numbers below zero
    bgt 1b
    b 2b
    .size __aeabi_fcmplt, . - __aeabi_fcmplt

    .balign 4
    .global __aeabi_fcmpge
    .type __aeabi_fcmpge, %function
    .thumb_func
__aeabi_fcmpge:
    mov r2, r0
    mov r0, r1
    mov r1, r2
    .global __aeabi_fcmple
    .type __aeabi_fcmple, %function
    .thumb_func
__aeabi_fcmple:
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
    bgt 2f
1:  movs r0, #1
    bx lr
2:  movs r0, #0
    bx lr
3:  lsls r2, r2, #1
    beq 1b                      @ two zeros
    mov r2, r0
    ands r2, r1
    bmi 4f
    cmp r0, r1
    ble 1b
    b 2b
4:  cmp r0, r1                  @ two numbers below zero
    bge 1b
    b 2b
    .size __aeabi_fcmple, . - __aeabi_fcmple
