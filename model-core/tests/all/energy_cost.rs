//! The energy of knowing the income.

use model_core::energy::cost::{
    Accelerometer, Adc, Clock, Code, ColdStart, CostModel, Evidence, Figure, Processor, Radio,
};

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
    for part in Clock::<f32>::all() {
        check(part.name, part.current, 14e-9, 55e-9);
    }
    let adc = Adc::<f32>::twelve_bits();
    check(adc.name, adc.reading, 1e-8, 1e-5);
    check(adc.name, adc.duration, 1e-6, 1e-3);
    let start = ColdStart::<f32>::typical();
    check("decoupling", start.decoupling, 1e-7, 1e-4);
    check("cold start", start.time, 1e-4, 1e-1);
    for part in Radio::<f32>::all() {
        check(part.name, part.transmitting, 1e-3, 0.1);
        check(part.name, part.ramp_up, 1e-5, 1e-2);
        check(part.name, part.overhead, 1e-5, 0.1);
        check(part.name, part.bit_rate, 1e3, 2e6);
    }
    for part in Accelerometer::<f32>::all() {
        check(part.name, part.slow.current, 1e-7, 1e-2);
        check(part.name, part.fast.current, 1e-7, 1e-2);
        assert!(part.slow.rate <= part.fast.rate, "{}", part.name);
        assert!(part.power(part.fast.rate).is_some(), "{}", part.name);
    }
}

#[test]
fn a_listen_behind_a_gated_supply_pays_for_its_start_and_for_waiting() {
    let sleeping = CostModel::<f64>::new(Processor::nrf52832(), Accelerometer::lis2dh12());
    let gated = sleeping.gated_by(Clock::ab18x5_crystal());
    let listen =
        |model: &CostModel<f64>| model.listen(64, 400.0, 1e4, Code::Filter).expect("a rate of the sensor");
    let (one, other) = (listen(&sleeping), listen(&gated));
    // 1 µF charged to 3 V, and 2 ms at 64 MHz and 174 pJ a cycle.
    assert!(near(gated.start_energy(), 1e-6 * 9.0 + 2e-3 * 64e6 * 174e-12));
    // Two fillings of the FIFO: the second is a wake-up from sleep.
    assert!(near(one.wake_up, 2.0 * sleeping.start_energy()), "{one:?}");
    assert!(near(other.wake_up, gated.start_energy() + sleeping.start_energy()), "{other:?}");
    // 1.9 µA at 3 V for 64 samples and 2 of start-up.
    assert!(near(other.waiting, 5.7e-6 * 66.0 / 400.0) && one.waiting == 0.0, "{other:?}");
    assert_eq!((other.computing, other.sensor, other.transfer), (one.computing, one.sensor, one.transfer));
    assert!(near(
        other.total() - one.total(),
        other.waiting + gated.start_energy() - sleeping.start_energy()
    ));
    assert!(near(gated.standing_power().expect("known"), 165e-9));
    // Nothing is known of the sleep of this one: its power while it waits is not either.
    let unknown = CostModel::<f64>::new(Processor::sam_d21(), Accelerometer::lis2dh12());
    assert_eq!(unknown.standing_power(), None);
    assert_eq!(unknown.gated_by(Clock::ab18x5_rc()).listen(64, 400.0, 1e4, Code::Filter), None);
}

#[test]
fn a_packet_takes_its_ramp_up_its_overhead_and_its_bits() {
    let radio = Radio::<f64>::nrf52832();
    let time = 0.5e-3 + 16.0 * 8e-6 + 20.0 * 8e-6;
    assert!(near(radio.packet_time(20).expect("fits"), time));
    assert!(near(radio.packet(20).expect("fits"), 7.1e-3 * 3.0 * time));
    assert_eq!((radio.packet(31).is_some(), radio.packet(32)), (true, None));
    // The time on air of LoRa with an explicit header, a checksum and 8 symbols of preamble goes by whole blocks; the
    // linear bound is at most a block above. 20 bytes at a spreading factor of 7 in 125 kHz are 56.6 ms.
    let radio = Radio::<f64>::sx1261_lora_sf7();
    for bytes in 0..=255_u32 {
        let blocks = ((8.0 * f64::from(bytes) - 28.0 + 28.0 + 16.0) / 28.0).ceil();
        let on_air = (12.25 + 8.0 + 5.0 * blocks) * 1.024e-3;
        let beyond = radio.packet_time(bytes).expect("fits") - radio.ramp_up.value - on_air;
        assert!((0.0..=10.3e-3).contains(&beyond), "{bytes}: {beyond}");
        assert!(bytes != 20 || near(on_air, 56.6e-3), "{on_air}");
    }
}

/// The table of the hard case in docs/energy.md: `cargo test -p model-core energy_cost::the_hard -- --nocapture`
#[test]
fn the_hard_case_lives_behind_a_gated_supply_only() {
    let income = 2.9e-6;
    // A block of the bank of lines, 16 sections of 80 samples, and a look-up in the map: instructions under QEMU.
    let samples = 1280;
    let parts = [
        (Processor::nrf52832(), f64::from(samples) * 13.0 + 587.0),
        (Processor::stm32l051(), f64::from(samples) * 35.0 + 988.0),
        (Processor::apollo3(), f64::from(samples) * 13.0 + 587.0),
    ];
    println!(
        "| part | supply | standing | of the income | listen | each | knowing | left for actions | a packet of 20 bytes each |"
    );
    for (processor, instructions) in parts {
        let own = CostModel::<f64>::new(processor, Accelerometer::adxl362());
        let left = [("on", own), ("gated", own.gated_by(Clock::ab18x5_crystal()))].map(|(supply, model)| {
            let standing = model.standing_power().expect("known");
            let listen =
                model.listen(samples, 400.0, instructions, Code::Filter).expect("a rate of the sensor");
            let reading = model.voltage_reading.value;
            let knowing = listen.total() + reading;
            let interval = knowing / (0.01 * income);
            let left = income - standing - 0.01 * income;
            let packet = Radio::<f64>::nrf52832().packet(20).expect("fits") + model.start_energy();
            let each = if left > 0.0 { format!("{:.1} s", packet / left) } else { "never".to_owned() };
            println!(
                "| {} | {supply} | {:.3} µW | {:.1} % | {:.2} µJ | {:.1} min | 1.0 % | {:.2} µW | {each} |",
                processor.name,
                1e6 * standing,
                100.0 * standing / income,
                1e6 * knowing,
                interval / 60.0,
                1e6 * left,
            );
            assert!(interval < 2.0 * 3600.0, "{}: {interval}", processor.name);
            left
        });
        // Asleep with its own clock each part takes most of the income or more; gated, nine tenths are left.
        assert!(left[0] < 0.2 * income && left[1] > 0.9 * income, "{}: {left:?}", processor.name);
    }
}
