//! Complex numbers `re + j im`, for the amplitudes of the closed forms.

use core::ops::{Add, Mul, Neg, Sub};

use super::Scalar;

/// `re + j im`. A quantity `Im(z e^{jωt})` has the amplitude `|z|` and the phase `arg z`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Complex<S> {
    pub(crate) re: S,
    pub(crate) im: S,
}

impl<S: Scalar> Complex<S> {
    pub(crate) const ZERO: Self = Self { re: S::ZERO, im: S::ZERO };

    pub(crate) fn new(re: S, im: S) -> Self {
        Self { re, im }
    }

    pub(crate) fn scaled(self, factor: S) -> Self {
        Self { re: factor * self.re, im: factor * self.im }
    }

    /// `|z|²`.
    pub(crate) fn square(self) -> S {
        self.re * self.re + self.im * self.im
    }

    /// `|z|`.
    pub(crate) fn magnitude(self) -> S {
        self.square().sqrt()
    }

    /// `1/z`; `|z|²` must neither overflow nor underflow.
    pub(crate) fn inverse(self) -> Self {
        let per_square = S::ONE / self.square();
        Self { re: self.re * per_square, im: -self.im * per_square }
    }
}

impl<S: Scalar> Add for Complex<S> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl<S: Scalar> Sub for Complex<S> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

impl<S: Scalar> Neg for Complex<S> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { re: -self.re, im: -self.im }
    }
}

impl<S: Scalar> Mul for Complex<S> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}
