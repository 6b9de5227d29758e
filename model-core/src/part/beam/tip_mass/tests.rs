use super::*;

/// 100 × 20 × 0.5 mm of steel.
const BEAM: Cantilever<f64> = Cantilever {
    length: 0.1,
    bending_stiffness: 210e9 * 0.02 * 1.25e-10 / 12.0,
    mass_per_length: 7800.0 * 0.02 * 0.0005,
    tip_mass: 0.0,
};
const BEAM_MASS: f64 = BEAM.mass_per_length * BEAM.length;

/// A body by its mass over that of the beam, its radius of gyration and its offset over the length.
fn body(mass: f64, gyration: f64, offset: f64) -> TipMass<f64> {
    let length = gyration * BEAM.length;
    TipMass {
        mass: mass * BEAM_MASS,
        rotary_inertia: mass * BEAM_MASS * length * length,
        offset: offset * BEAM.length,
    }
}

/// Bodies from a hundredth to a thousand beam masses, points and long ones.
fn bodies() -> impl Iterator<Item = TipMass<f64>> {
    let masses = [1e-2, 0.3, 1.0, 4.0, 1e3];
    let shapes = [[0.0, 0.0], [0.05, 0.0], [0.1, 0.1], [0.02, 0.3], [0.4, 0.05], [0.0, 0.2], [1.0, 1.0]];
    masses.into_iter().flat_map(move |mass| shapes.map(|[gyration, offset]| body(mass, gyration, offset)))
}

fn single(body: TipMass<f64>) -> TipMass<f32> {
    TipMass { mass: body.mass as f32, rotary_inertia: body.rotary_inertia as f32, offset: body.offset as f32 }
}

fn single_beam() -> Cantilever<f32> {
    Cantilever {
        length: BEAM.length as f32,
        bending_stiffness: BEAM.bending_stiffness as f32,
        mass_per_length: BEAM.mass_per_length as f32,
        tip_mass: 0.0,
    }
}

fn close(value: f64, expected: f64, relative: f64) {
    assert!((value / expected - 1.0).abs() < relative, "{value} is not {expected} within {relative}");
}

/// Determinant of the four boundary conditions, in the functions `cos u`, `sin u`, `e^−u` and `e^(u − λ)`.
fn boundary_conditions(body: &TipMass<f64>, lambda: f64) -> f64 {
    let mass = body.mass / BEAM_MASS;
    let offset = body.offset / BEAM.length;
    let about_tip = body.rotary_inertia / (BEAM_MASS * BEAM.length * BEAM.length) + mass * offset * offset;
    let decay = (-lambda).exp();
    let (sine, cosine) = lambda.sin_cos();
    // The functions and three derivatives by u, at the clamp and at the tip.
    let clamp = [[1.0, 0.0, 1.0, decay], [0.0, 1.0, -1.0, decay]];
    let tip = [
        [cosine, sine, decay, 1.0],
        [-sine, cosine, -decay, 1.0],
        [-cosine, -sine, decay, 1.0],
        [sine, -cosine, -decay, 1.0],
    ];
    let mut rows = [clamp[0], clamp[1], [0.0; 4], [0.0; 4]];
    for column in 0..4 {
        let [value, slope, curvature, shear] = tip.map(|row| row[column]);
        let slope = lambda * slope;
        rows[2][column] = shear + lambda * mass * (value + offset * slope);
        rows[3][column] = curvature - lambda * lambda * (about_tip * slope + mass * offset * value);
    }
    let mut determinant = 1.0;
    for column in 0..4 {
        let pivot = (column..4)
            .max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()))
            .expect("rows");
        if pivot != column {
            rows.swap(pivot, column);
            determinant = -determinant;
        }
        determinant *= rows[column][column];
        let pivot_row = rows[column];
        for row in &mut rows[column + 1..] {
            let factor = row[column] / pivot_row[column];
            for (entry, of_pivot) in row.iter_mut().zip(pivot_row).skip(column) {
                *entry -= factor * of_pivot;
            }
        }
    }
    determinant
}

/// The first `count` roots: sign changes on a fine grid, bisected.
fn exact(body: &TipMass<f64>, count: usize) -> Vec<f64> {
    let step = 2e-4;
    let mut roots = Vec::new();
    let mut at = 1e-2;
    let mut before = boundary_conditions(body, at);
    while roots.len() < count {
        let after = boundary_conditions(body, at + step);
        if (before < 0.0) != (after < 0.0) {
            let (mut low, mut high) = (at, at + step);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if (boundary_conditions(body, middle) < 0.0) == (before < 0.0) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            roots.push(0.5 * (low + high));
        }
        (before, at) = (after, at + step);
    }
    roots
}

#[test]
fn eigenvalues_are_those_of_the_boundary_conditions() {
    for body in bodies() {
        for (number, root) in (1..).zip(exact(&body, 6)) {
            let found = BEAM.mode_with(&body, number).eigenvalue;
            assert!((found / root - 1.0).abs() < 1e-9, "{body:?} {number}: {found} {root}");
        }
    }
}

#[test]
fn a_point_mass_is_the_tip_mass_of_the_beam() {
    for mass in [0.0, 1e-3, 8e-3, 0.5] {
        let body = TipMass { mass, rotary_inertia: 0.0, offset: 0.0 };
        let known = Cantilever { tip_mass: mass, ..BEAM };
        for number in 1..=8 {
            let (found, expected) = (BEAM.mode_with(&body, number), known.mode(number));
            close(found.eigenvalue, expected.eigenvalue, 1e-14);
            close(found.base_coupling, expected.base_coupling, 1e-11);
            for place in [0.3, 1.0] {
                let difference = found.shape(place).value - expected.shape(place).value;
                assert!(difference.abs() < 1e-11 * expected.scale, "{mass} {number} {difference}");
            }
        }
    }
}

/// `λ²` of a point mass of the beam's mass: Math. Probl. Eng. (2017) 1568019, table 1, without rotary inertia. A free end
/// has the roots of `cos λ cosh λ = −1`.
#[test]
fn eigenvalues_are_the_published_ones() {
    let squares = [1.557_298, 16.250_09, 50.895_84, 105.198_3, 179.232_0];
    for (number, square) in (1..).zip(squares) {
        let found = BEAM.mode_with(&body(1.0, 0.0, 0.0), number).eigenvalue;
        close(found * found, square, 4e-7);
    }
    let free = [1.875_104_07, 4.694_091_13, 7.854_757_44, 10.995_540_73, 14.137_168_39];
    for (number, known) in (1..).zip(free) {
        close(BEAM.mode_with(&body(0.0, 0.0, 0.0), number).eigenvalue, known, 2e-9);
    }
}

#[test]
fn heavy_bodies_swing_on_a_massless_spring() {
    let cube = BEAM.length.powi(3);
    // A point mass: k = 3EI/L³.
    let heavy = body(1e6, 0.0, 0.0);
    let mode = BEAM.mode_with(&heavy, 1);
    close(mode.angular_frequency.powi(2), 3.0 * BEAM.bending_stiffness / (cube * heavy.mass), 1e-6);
    close(mode.base_coupling, heavy.mass.sqrt(), 1e-6);
    // A body: EI/L³ [[12, −6], [−6, 4]] against [[μ, μe], [μe, j]], two modes.
    for (gyration, offset) in [(0.1, 0.2), (0.02, 0.0), (1.0, 0.5)] {
        let heavy = body(1e6, gyration, offset);
        let inertia = gyration * gyration + offset * offset;
        let [a, b, c] = [gyration * gyration, -(12.0 * inertia + 12.0 * offset + 4.0), 12.0];
        let root = (b * b - 4.0 * a * c).sqrt();
        let unit = BEAM.bending_stiffness / (cube * heavy.mass);
        for (number, square) in [(1, 2.0 * c / (-b + root)), (2, (-b + root) / (2.0 * a))] {
            let mode = BEAM.mode_with(&heavy, number);
            close(mode.angular_frequency.powi(2), square * unit, 1e-3);
        }
    }
}

/// Orthonormal with the terms of the body, and the modal masses of a base motion make the whole mass.
#[test]
fn modes_are_orthonormal_and_carry_the_whole_mass() {
    let integral = |integrand: &dyn Fn(f64) -> f64| {
        let weight = |k: u32| if k == 0 || k == 2000 { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        (0..=2000).map(|k| weight(k) * integrand(f64::from(k) / 2000.0)).sum::<f64>() / 6000.0
    };
    for body in bodies() {
        let mut coupled = 0.0;
        let ends = |mode: &BeamMode<f64>| {
            let tip = mode.shape(1.0);
            [tip.value + body.offset * tip.slope / BEAM.length, tip.slope / BEAM.length]
        };
        for i in 1..=6 {
            let one = BEAM.mode_with(&body, i);
            let [centre, turn] = ends(&one);
            for j in 1..=i {
                let other = BEAM.mode_with(&body, j);
                let [other_centre, other_turn] = ends(&other);
                let product = BEAM_MASS * integral(&|s| one.shape(s).value * other.shape(s).value)
                    + body.mass * centre * other_centre
                    + body.rotary_inertia * turn * other_turn;
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 5e-9, "{body:?} {i} {j} {product}");
            }
            let moment = BEAM_MASS * integral(&|s| one.shape(s).value) + body.mass * centre;
            let scale = (BEAM_MASS + body.mass).sqrt();
            assert!((one.base_coupling - moment).abs() < 1e-9 * scale, "{body:?} {i}");
            coupled += one.base_coupling.powi(2);
        }
        let whole = BEAM_MASS + body.mass;
        assert!(coupled < whole * (1.0 + 1e-12) && coupled > 0.92 * whole, "{body:?} {}", coupled / whole);
    }
}

/// No root is missed or found twice: the strain energy of each mode is its ω², and the numbers rise.
#[test]
fn every_mode_has_the_strain_energy_of_its_frequency() {
    let stiffness = BEAM.bending_stiffness / BEAM.length.powi(3);
    for body in bodies() {
        let mut before = 0.0;
        for number in 1..=20 {
            let mode = BEAM.mode_with(&body, number);
            assert!(mode.eigenvalue > before, "{body:?} {number}");
            before = mode.eigenvalue;
            let weight = |k: u32| if k == 0 || k == 4000 { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            let square = |k: u32| mode.shape(f64::from(k) / 4000.0).curvature.powi(2);
            let strain = stiffness * (0..=4000).map(|k| weight(k) * square(k)).sum::<f64>() / 12_000.0;
            let expected = mode.angular_frequency.powi(2);
            assert!((strain / expected - 1.0).abs() < 2e-6, "{body:?} {number} {}", strain / expected);
        }
    }
}

/// All modes together have the static compliance `x³/3EI`, whatever the body.
#[test]
fn retained_and_residual_modes_make_the_whole_compliance() {
    for body in bodies() {
        for place in [1.0, 0.5, 0.3] {
            let whole = (place * BEAM.length).powi(3) / (3.0 * BEAM.bending_stiffness);
            for modes in [0_u32, 1, 4, 10] {
                let term = |number| {
                    let mode = BEAM.mode_with(&body, number);
                    (mode.shape(place).value / mode.angular_frequency).powi(2)
                };
                let modal_part: f64 = (1..=modes).map(term).sum();
                let rest = BEAM.residual_compliance_with(&body, place, modes);
                let error = modal_part + rest - whole;
                assert!(error.abs() < 3e-4 * rest + 1e-12 * whole, "{body:?} {place} {modes} {error} {rest}");
                let coarse = single_beam().residual_compliance_with(&single(body), place as f32, modes);
                let error = f64::from(coarse) - rest;
                assert!(error.abs() < 1e-4 * rest + 1e-7 * whole, "{body:?} {place} {modes} {error} {rest}");
            }
        }
    }
}

#[test]
fn single_precision_is_as_good_as_its_rounding() {
    for body in bodies() {
        for number in 1..=10 {
            let (fine, coarse) =
                (BEAM.mode_with(&body, number), single_beam().mode_with(&single(body), number));
            close(coarse.eigenvalue.into(), fine.eigenvalue, 1e-6);
            for s in [0.2, 0.5, 0.83, 1.0] {
                let difference = f64::from(coarse.shape(s as f32).value) - fine.shape(s).value;
                assert!(difference.abs() < 2e-5 * fine.scale, "{body:?} {number} {s} {difference}");
            }
            let difference = f64::from(coarse.base_coupling) - fine.base_coupling;
            assert!(
                difference.abs() < 1e-5 * (BEAM_MASS + body.mass).sqrt(),
                "{body:?} {number} {difference}"
            );
        }
    }
}

#[test]
fn bodies_out_of_bounds_are_named() {
    let refused = |body: TipMass<f64>| body.check(&BEAM).err().map(|error| error.field);
    assert_eq!(refused(body(1.0, 0.1, 0.1)), None);
    assert_eq!(refused(TipMass { mass: -1e-9, ..body(1.0, 0.1, 0.1) }), Some("tip_mass.mass"));
    assert_eq!(
        refused(TipMass { rotary_inertia: f64::NAN, ..body(1.0, 0.1, 0.1) }),
        Some("tip_mass.rotary_inertia")
    );
    assert_eq!(refused(TipMass { offset: -1e-3, ..body(1.0, 0.1, 0.1) }), Some("tip_mass.offset"));
    assert_eq!(refused(body(1.1e4, 0.0, 0.0)), None);
    assert_eq!(
        refused(TipMass { offset: 1.1, ..body(1.0, 0.1, 0.1) }),
        Some("tip_mass.offset / beam_length")
    );
    let thin = Cantilever { mass_per_length: 1e-9, ..BEAM };
    let error = body(1.0, 0.0, 0.0).check(&thin).expect_err("too heavy for this beam");
    assert_eq!(error.field, "tip_mass.mass / mass of the beam");
    let long = TipMass { mass: 0.0, rotary_inertia: 1e3, offset: 0.0 };
    assert!(refused(long).is_some_and(|field| field.starts_with("tip_mass.rotary_inertia /")));
}
