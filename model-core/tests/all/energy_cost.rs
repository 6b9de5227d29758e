//! The energy of knowing the income.

use model_core::energy::cost::{Accelerometer, Code, CostModel, Evidence, Figure, Processor};

/// Whether `value` is `expected` within half a per cent: the precision of the published figures.
fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 5e-3 * expected
}

#[test]
fn a_second_of_following_costs_what_its_parts_cost() {
    let model = CostModel::<f64>::new(Processor::nrf52832(), Accelerometer::adxl362());
    // 3195 instructions a sample at 400 Hz: 400 µJ computing and 6 µJ of the sensor.
    let cost = model.follow(400, 400.0, 400.0 * 3195.0, Code::Trajectory).expect("a rate of the sensor");
    assert!(near(cost.computing, 400.3e-6), "{cost:?}");
    assert!(near(cost.sensor, 6e-6), "{cost:?}");
    // A wake-up of 3 µs at 64 MHz and 174 pJ a cycle for each sample, 48 bits a sample.
    assert!(near(cost.wake_up, 400.0 * 33.4e-9), "{cost:?}");
    assert!(near(cost.transfer, 400.0 * 48.0 * 0.5e-9), "{cost:?}");
    assert_eq!(cost.total(), cost.computing + cost.sensor + cost.transfer + cost.wake_up);
    // 146 times an income of 2.9 µJ.
    assert!(near(cost.share_of(2.9e-6), cost.total() / 2.9e-6), "{cost:?}");
    assert_eq!(cost.share_of(0.0), f64::INFINITY);
}

#[test]
fn a_listen_pays_for_the_start_up_and_wakes_up_once_for_each_filling_of_the_fifo() {
    let model = CostModel::<f64>::new(Processor::stm32l051(), Accelerometer::lis2dh12());
    let wake_up = model.processor.wake_up_energy();
    assert!(near(wake_up, 264e-12 * 32e6 * 5e-6), "{wake_up}");
    for (samples, fillings) in [(1, 1.0), (32, 1.0), (33, 2.0), (64, 2.0), (65, 3.0)] {
        let cost = model.listen(samples, 400.0, 0.0, Code::Filter).expect("a rate of the sensor");
        assert!(near(cost.wake_up, fillings * wake_up), "{samples} {cost:?}");
        assert!(near(cost.sensor, 36e-6 * 2.5 * (f64::from(samples) + 2.0) / 400.0), "{samples} {cost:?}");
    }
}

#[test]
fn the_interval_for_a_share_spends_that_share() {
    let model = CostModel::<f64>::new(Processor::apollo3(), Accelerometer::adxl362());
    let cost = model.listen(160, 400.0, 160.0 * 60.0, Code::Filter).expect("a rate of the sensor");
    let (share, income) = (0.01, 2.9e-6);
    let interval = cost.interval_for(share, income);
    assert!(near(cost.total() / interval, share * income), "{interval}");
    assert!(near(cost.share_of(income * interval), share), "{interval}");
    assert_eq!(cost.interval_for(share, 0.0), f64::INFINITY);
}

#[test]
fn a_sensor_interpolates_between_its_rates_and_refuses_rates_above() {
    let sensor = Accelerometer::<f64>::adxl362();
    let power = |rate| sensor.power(rate);
    assert_eq!(power(100.0), Some(1.8e-6 * 2.0));
    assert_eq!(power(12.5), power(100.0));
    assert!(near(power(250.0).expect("between"), 2.4e-6 * 2.0));
    assert_eq!(power(400.0), Some(3.0e-6 * 2.0));
    assert_eq!([power(400.1), power(0.0), power(-1.0), power(f64::NAN)], [None; 4]);
    let model = CostModel::new(Processor::nrf52832(), Accelerometer::adxl367());
    assert_eq!(model.listen(10, 400.0, 0.0, Code::Filter), None);
}

#[test]
fn every_figure_is_a_number_with_a_source() {
    let check = |part: &str, figure: Figure<f32>, low: f32, high: f32| {
        assert!((low..=high).contains(&figure.value), "{part}: {figure:?}");
        assert!(!figure.source.is_empty(), "{part}: {figure:?}");
        // A figure of a data sheet is not an estimate.
        assert!(figure.evidence != Evidence::Estimated || !figure.source.contains("sheet"), "{part}");
    };
    for part in Processor::<f32>::all() {
        check(part.name, part.energy_per_cycle, 10e-12, 1e-9);
        check(part.name, part.clock, 1e6, 200e6);
        check(part.name, part.wake_up, 1e-6, 1e-3);
        part.sleep.into_iter().for_each(|sleep| check(part.name, sleep, 1e-8, 1e-5));
        for code in [Code::Trajectory, Code::Filter] {
            check(part.name, part.cycles_per_instruction(code), 1.0, 4.0);
        }
        let standing = CostModel::new(part, Accelerometer::adxl362()).standing_power();
        assert_eq!(standing, part.sleep.map(|sleep| sleep.value * part.supply));
    }
    for part in Accelerometer::<f32>::all() {
        check(part.name, part.slow.current, 1e-7, 1e-2);
        check(part.name, part.fast.current, 1e-7, 1e-2);
        assert!(part.slow.rate <= part.fast.rate, "{}", part.name);
        assert!(part.power(part.fast.rate).is_some(), "{}", part.name);
    }
}
