//! `node-years`: years of a node of either tier on all storages.

use super::count;
use super::node_strategies::print_rows;
use crate::method::Failure;
use crate::outcome::Format;
use crate::simulated_node::{Quarter, STORAGES, years};

#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Run time: minutes of CPU for ten years, on all cores")]
pub struct NodeYearsArguments {
    /// Years
    #[arg(long, value_name = "COUNT", default_value_t = 10, value_parser = count::<u32>(1..=50))]
    years: u32,
    /// Output format; the table has of each node the quarter with the fewest hours inside
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

/// Runs all nodes and prints their quarters.
pub fn run(arguments: &NodeYearsArguments) -> Result<(), Failure> {
    let quarters = years(365 * arguments.years, &STORAGES)?;
    if arguments.format != Format::Table {
        return print_rows(&quarters, arguments.format, 2);
    }
    let of_a_node = |one: &Quarter, other: &Quarter| other.quarter > one.quarter;
    let worst =
        |node: &[Quarter]| node.iter().min_by(|one, other| one.inside.total_cmp(&other.inside)).copied();
    let worst: Vec<Quarter> = quarters.chunk_by(of_a_node).filter_map(worst).collect();
    print_rows(&worst, arguments.format, 2)
}
