//! The smooth scene by model-core and by the crate numeris: `on-target --peer`.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    use firmware_example::measure;
    use firmware_example::workload::contact_separation::scenes;
    use firmware_example::workload::{Workload, peer::Rodas4};

    scenes::with_smooth(|ours| {
        let Some([a, b, c, d]) = ours else { measure::refused() };
        let [mut e, mut f, mut g, mut h] = scenes::PEER_TOLERANCES.map(Rodas4::new);
        let peer: [&mut dyn Workload; 4] = [&mut e, &mut f, &mut g, &mut h];
        let [e, f, g, h] = peer;
        measure::run(&mut [*a, *b, *c, *d, e, f, g, h])
    })
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", firmware_example::HOW_TO_BUILD);
}
