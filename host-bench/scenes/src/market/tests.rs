//! Parts, and the energy of estimating the income.

use super::*;

fn model(processor: &str, accelerometer: &str) -> CostModel {
    let processor = Processor::named(processor).expect("a part");
    CostModel::new(processor, Accelerometer::named(accelerometer).expect("a part"))
}

fn clock(word: &str) -> Clock {
    Clock::named(word).expect("a part")
}

/// Whether `value` is `expected` within half a per cent: the precision of the published figures.
fn near(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 5e-3 * expected
}

#[test]
fn a_burst_costs_what_its_parts_cost() {
    // 3195 instructions a sample: 400 µJ computing; 4 samples of start-up at 6 µW; 48 bits a sample; 3 fillings of 170.
    let model = model("nrf52832", "adxl362");
    let cost = model.burst(400, 400.0, 400.0 * 3195.0, Code::Trajectory).expect("a rate of the sensor");
    assert!(near(cost.computing, 400.3e-6) && near(cost.sensor, 6e-6 * 404.0 / 400.0), "{cost:?}");
    assert!(near(cost.wake_up, 3.0 * 33.4e-9) && near(cost.transfer, 400.0 * 48.0 * 0.5e-9), "{cost:?}");
    assert_eq!(cost.total(), cost.computing + cost.sensor + cost.transfer + cost.wake_up);
}

#[test]
fn a_burst_pays_for_the_start_up_and_wakes_up_once_for_each_filling_of_the_fifo() {
    let model = model("stm32l051", "lis2dh12");
    let wake_up = model.processor.wake_up_energy();
    assert!(near(wake_up, 264e-12 * 32e6 * 5e-6), "{wake_up}");
    for (samples, fillings) in [(1, 1.0), (32, 1.0), (33, 2.0), (64, 2.0), (65, 3.0)] {
        let cost = model.burst(samples, 400.0, 0.0, Code::Filter).expect("a rate of the sensor");
        assert!(near(cost.wake_up, fillings * wake_up), "{samples} {cost:?}");
        assert!(near(cost.sensor, 36e-6 * 2.5 * (f64::from(samples) + 2.0) / 400.0), "{samples} {cost:?}");
    }
}

#[test]
fn a_sensor_interpolates_between_its_rates_and_refuses_rates_above() {
    let sensor = Accelerometer::all()[0];
    let power = |rate| sensor.power(rate);
    assert_eq!(power(100.0), Some(1.8e-6 * 2.0));
    assert_eq!(power(12.5), power(100.0));
    assert!(near(power(250.0).expect("between"), 2.4e-6 * 2.0));
    assert_eq!(power(400.0), Some(3.0e-6 * 2.0));
    assert_eq!([power(400.1), power(0.0), power(-1.0), power(f64::NAN)], [None; 4]);
    let model = model("nrf52832", "adxl367");
    assert_eq!(model.burst(10, 400.0, 0.0, Code::Filter), None);
}

#[test]
fn every_figure_is_a_number_with_a_source() {
    let check = |part: &str, figure: Figure, low: f64, high: f64| {
        let Figure(value, evidence, source) = figure;
        assert!((low..=high).contains(&value), "{part}: {figure:?}");
        assert!(!source.is_empty(), "{part}: {figure:?}");
        // A figure of a data sheet is not an estimate.
        assert!(evidence != Evidence::Estimated || !source.contains("sheet"), "{part}");
    };
    for part in Processor::all() {
        check(part.name, part.energy_per_cycle_j, 10e-12, 1e-9);
        check(part.name, part.clock_hz, 1e6, 200e6);
        check(part.name, part.wake_up_s, 1e-6, 1e-3);
        part.sleep_a.into_iter().for_each(|sleep| check(part.name, sleep, 1e-8, 1e-5));
        for code in [Code::Trajectory, Code::Filter] {
            check(part.name, part.cycles_per_instruction(code), 1.0, 4.0);
        }
        let standing = model(part.word, "adxl362").standing_power();
        assert_eq!(standing, part.sleep_a.map(|sleep| sleep.0 * part.supply_v));
    }
    Clock::all().iter().for_each(|part| check(part.name, part.current_a, 14e-9, 55e-9));
    check("ADC", MARKET.adc.reading_j, 1e-8, 1e-5);
    check("ADC", MARKET.adc.duration_s, 1e-6, 1e-3);
    check("decoupling", ColdStart::typical().decoupling_f, 1e-7, 1e-4);
    check("cold start", ColdStart::typical().time_s, 1e-4, 1e-1);
    for part in Radio::all() {
        check(part.name, part.transmitting_a, 1e-3, 0.1);
        check(part.name, part.ramp_up_s, 1e-5, 1e-2);
        check(part.name, part.overhead_s, 1e-5, 0.1);
        check(part.name, part.bit_rate_hz, 1e3, 2e6);
    }
    for part in Battery::all() {
        let Battery { half_v, charge_c, resistance_ohm, charging_efficiency, tolerance, .. } = *part;
        check(part.name, half_v, 1.0, 5.0);
        check(part.name, charge_c, 0.01, 1e5);
        check(part.name, resistance_ohm, 1e-3, 1e5);
        check(part.name, charging_efficiency, 0.5, 1.0);
        check(part.name, part.self_discharge_per_s, 1e-11, 1e-6);
        check(part.name, tolerance, 0.0, 0.3);
        // The core takes it, and the line has the stated voltage at half charge.
        let curve = part.of_core().curve::<f64>(0.0).expect(part.word);
        let after = part.open_circuit.iter().position(|point| point[0] >= 0.5).expect("rises to 1");
        let [[from, low], [to, high]] = [part.open_circuit[after - 1], part.open_circuit[after]];
        let half = f64::from(low + (high - low) * (0.5 - from) / (to - from));
        assert!((half - half_v.0).abs() < 1e-3, "{half}");
        // The integral by the core is that of the host, over the whole line.
        let reservoir = Reservoir { capacitance_f: 0.0, leakage_ohm: f64::INFINITY, battery: Some(*part) };
        for step in 0..=1000 {
            let [lowest, highest] =
                [0, part.open_circuit.len() - 1].map(|at| f64::from(part.open_circuit[at][1]));
            let voltage = lowest + (highest - lowest) * f64::from(step) / 1000.0;
            let energy = reservoir.energy_j(voltage);
            assert!((curve.energy(voltage) - energy).abs() < 1e-6 * charge_c.0, "{voltage}: {energy}");
            assert!((reservoir.voltage_v(energy) - voltage).abs() < 1e-9, "{voltage}: {energy}");
        }
    }
    for part in Accelerometer::all() {
        check(part.name, part.slow_current_a, 1e-7, 1e-2);
        check(part.name, part.fast_current_a, 1e-7, 1e-2);
        assert!(part.rates_hz[0] <= part.rates_hz[1], "{}", part.name);
        assert!(part.power(part.rates_hz[1]).is_some(), "{}", part.name);
    }
}

#[test]
fn presets_state_their_quiescent_currents_at_the_turn_on_voltage() {
    for preset in Preset::all() {
        assert!(preset.running_a >= preset.locked_out_a, "{}", preset.word);
        let Some(Lockout { turn_on_v, turn_off_v }) = preset.lockout else {
            assert_eq!(preset.leakage_ohm(), f64::INFINITY);
            continue;
        };
        assert!(0.0 < turn_off_v && turn_off_v < turn_on_v, "{}", preset.word);
        assert!(preset.highest_v.is_none_or(|highest| turn_on_v < highest), "{}", preset.word);
        assert!(near(turn_on_v / preset.leakage_ohm(), preset.locked_out_a), "{}", preset.word);
        let running = preset.power_at_store(0.0) / turn_on_v + preset.locked_out_a;
        assert!(near(running, preset.running_a), "{}", preset.word);
    }
    // 100 µW through 0.85, and 500 nA at 5.05 V.
    let preset = Preset::named("ltc3588-1-3v3").expect("a part");
    assert!((preset.power_at_store(100e-6) - (100e-6 / 0.85 + 2.525e-6)).abs() < 1e-18);
    assert_eq!(Preset::named("diodes").map(|preset| preset.power_at_store(3e-6)), Some(3e-6));
}

#[test]
fn each_word_names_one_part() {
    let of_storages = [Battery::words(), Preset::words()];
    for words in [Processor::words(), Clock::words(), Accelerometer::words(), Radio::words()]
        .into_iter()
        .chain(of_storages)
    {
        assert!(
            words.iter().all(|word| words.iter().filter(|other| *other == word).count() == 1),
            "{words:?}"
        );
        assert!(
            words.iter().all(|word| !word.contains(|letter: char| letter == ' ' || letter.is_uppercase()))
        );
    }
}

#[test]
fn a_burst_behind_a_gated_supply_pays_for_its_start_and_for_waiting() {
    let sleeping = model("nrf52832", "lis2dh12");
    let gated = sleeping.gated_by(clock("ab18x5-crystal"));
    let burst = |model: &CostModel| model.burst(64, 400.0, 1e4, Code::Filter).expect("a rate of the sensor");
    let (one, other) = (burst(&sleeping), burst(&gated));
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
    let unknown = model("sam-d21", "lis2dh12");
    assert_eq!(unknown.standing_power(), None);
    assert_eq!(unknown.gated_by(clock("ab18x5-rc")).burst(64, 400.0, 1e4, Code::Filter), None);
}

#[test]
fn a_packet_takes_its_ramp_up_its_overhead_and_its_bits() {
    let radio = Radio::named("nrf52832-0-dbm").expect("a part");
    let time = 0.5e-3 + 16.0 * 8e-6 + 20.0 * 8e-6;
    assert!(near(radio.packet_time(20).expect("fits"), time));
    assert!(near(radio.packet(20).expect("fits"), 7.1e-3 * 3.0 * time));
    assert_eq!((radio.packet(31).is_some(), radio.packet(32)), (true, None));
    // The time on air of LoRa with an explicit header, a checksum and 8 symbols of preamble goes by whole blocks; the
    // linear bound is at most a block above. 20 bytes at a spreading factor of 7 in 125 kHz are 56.6 ms.
    let radio = Radio::named("sx1261-lora-sf7-14-dbm").expect("a part");
    for bytes in 0..=255_u32 {
        let blocks = ((8.0 * f64::from(bytes) - 28.0 + 28.0 + 16.0) / 28.0).ceil();
        let on_air = (12.25 + 8.0 + 5.0 * blocks) * 1.024e-3;
        let beyond = radio.packet_time(bytes).expect("fits") - radio.ramp_up_s.0 - on_air;
        assert!((0.0..=10.3e-3).contains(&beyond), "{bytes}: {beyond}");
        assert!(bytes != 20 || near(on_air, 56.6e-3), "{on_air}");
    }
}

/// The table of the hard case in docs/energy.md: `cargo test -p harvester-scene the_hard -- --nocapture`
#[test]
fn the_hard_case_lives_behind_a_gated_supply_only() {
    let income = 2.9e-6;
    // A block of the bank of lines, 16 sections of 80 samples, and a look-up in the map: instructions under QEMU.
    let samples = 1280;
    let parts = [
        ("nrf52832", f64::from(samples) * 13.0 + 587.0),
        ("stm32l051", f64::from(samples) * 35.0 + 988.0),
        ("apollo3", f64::from(samples) * 13.0 + 587.0),
    ];
    println!(
        "| part | supply | standing | of the income | a burst | each | estimation | left for actions | a packet of 20 bytes each |"
    );
    for (processor, instructions) in parts {
        let own = model(processor, "adxl362");
        let left = [("on", own), ("gated", own.gated_by(clock("ab18x5-crystal")))].map(|(supply, model)| {
            let standing = model.standing_power().expect("known");
            let burst =
                model.burst(samples, 400.0, instructions, Code::Filter).expect("a rate of the sensor");
            let reading = model.adc.reading_j.0;
            let knowing = burst.total() + reading;
            let interval = knowing / (0.01 * income);
            let left = income - standing - 0.01 * income;
            let packet = Radio::named("nrf52832-0-dbm").expect("a part").packet(20).expect("fits")
                + model.start_energy();
            let each = if left > 0.0 { format!("{:.1} s", packet / left) } else { "never".to_owned() };
            println!(
                "| {} | {supply} | {:.3} µW | {:.1} % | {:.2} µJ | {:.1} min | 1.0 % | {:.2} µW | {each} |",
                own.processor.name,
                1e6 * standing,
                100.0 * standing / income,
                1e6 * knowing,
                interval / 60.0,
                1e6 * left,
            );
            assert!(interval < 2.0 * 3600.0, "{processor}: {interval}");
            left
        });
        // Asleep with its own clock each part takes most of the income or more; gated, nine tenths are left.
        assert!(left[0] < 0.2 * income && left[1] > 0.9 * income, "{processor}: {left:?}");
    }
}
