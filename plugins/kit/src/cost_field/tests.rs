use super::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const RULES: [StepRule; 3] = [
    StepRule { diagonal_step: std::f64::consts::SQRT_2, corner_cutting: false },
    StepRule { diagonal_step: std::f64::consts::SQRT_2, corner_cutting: true },
    StepRule { diagonal_step: 1.4, corner_cutting: true },
];

fn bits(costs: &[f64]) -> Vec<u64> {
    costs.iter().map(|c| c.to_bits()).collect()
}

fn random_costs(rng: &mut Xoshiro256PlusPlus, size: GridSize, blocked: f64, spread: f64) -> Vec<f64> {
    let one = |_| {
        if rng.random_bool(blocked) { f64::INFINITY } else { 1.0 + spread * rng.random_range(0.0..1.0_f64) }
    };
    (0..size.n_cells()).map(one).collect()
}

fn random_size(rng: &mut Xoshiro256PlusPlus) -> GridSize {
    GridSize::new(1 + rng.next_u32() as usize % 150, 1 + rng.next_u32() as usize % 150)
}

#[test]
fn the_field_equals_dijkstra_with_a_heap_to_the_bit() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(21);
    let mut field = CostField::new();
    for round in 0..120 {
        let size = random_size(&mut rng);
        let blocked = [0.0, 0.1, 0.3, 0.42][round % 4];
        let spread = [0.0, 1.0, 30.0][round % 3];
        let entries = random_costs(&mut rng, size, blocked, spread);
        let rule = RULES[rng.next_u32() as usize % 3];
        field.set_entry_costs(size, &entries, rule);
        for _ in 0..2 {
            let source = rng.random_range(0..size.n_cells());
            field.grow(source, Until::Everywhere, || false).unwrap();
            let oracle = slow::cost_field(size, &entries, rule, source);
            assert_eq!(
                bits(&field.to_vec()),
                bits(&oracle),
                "round {round}, {size:?}, {rule:?}, source {source}"
            );
        }
    }
}

#[test]
fn walls_with_long_detours_are_gone_round_exactly() {
    let mut field = CostField::new();
    let size = GridSize::new(130, 131);
    let mut entries = vec![1.0; size.n_cells()];
    for wall in (3..130).step_by(4) {
        for col in 0..size.width - 1 {
            let col = if wall / 4 % 2 == 0 { col } else { col + 1 };
            entries[size.index(col, wall)] = f64::INFINITY;
        }
    }
    for rule in RULES {
        field.set_entry_costs(size, &entries, rule);
        field.grow(0, Until::Everywhere, || false).unwrap();
        assert_eq!(bits(&field.to_vec()), bits(&slow::cost_field(size, &entries, rule, 0)), "{rule:?}");
    }
}

#[test]
fn a_query_and_a_settled_cell_have_the_exact_cost() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(22);
    let mut field = CostField::new();
    for round in 0..150 {
        let size = random_size(&mut rng);
        let entries = random_costs(&mut rng, size, [0.0, 0.2, 0.38][round % 3], [0.0, 3.0][round % 2]);
        let rule = RULES[round % 3];
        field.set_entry_costs(size, &entries, rule);
        let (source, cell) = (rng.random_range(0..size.n_cells()), rng.random_range(0..size.n_cells()));
        let oracle = slow::cost_field(size, &entries, rule, source);
        field.grow(source, Until::Query(cell), || false).unwrap();
        assert_eq!(field.cost(cell).to_bits(), oracle[cell].to_bits(), "query in round {round}");
        field.grow(source, Until::Settled(cell), || false).unwrap();
        for other in (0..size.n_cells()).filter(|&c| oracle[c] <= oracle[cell]) {
            assert_eq!(field.cost(other).to_bits(), oracle[other].to_bits(), "settled in round {round}");
        }
    }
}

#[test]
fn what_is_not_above_zero_blocks_and_a_blocked_source_reaches_nothing() {
    let mut field = CostField::new();
    let size = GridSize::new(3, 1);
    for bad in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        field.set_entry_costs(size, &[1.0, bad, 1.0], StepRule::default());
        field.grow(0, Until::Everywhere, || false).unwrap();
        assert_eq!(field.to_vec(), [0.0, f64::INFINITY, f64::INFINITY]);
        field.grow(1, Until::Everywhere, || false).unwrap();
        assert_eq!(field.to_vec(), [f64::INFINITY; 3]);
    }
}

#[test]
fn giving_up_ends_the_growth() {
    let mut field = CostField::new();
    let size = GridSize::new(200, 200);
    field.set_entry_costs(size, &vec![1.0; size.n_cells()], StepRule::default());
    let mut n_asked = 0;
    let answer = field.grow(0, Until::Everywhere, || {
        n_asked += 1;
        n_asked > 5
    });
    assert_eq!((answer, n_asked), (Err(GivenUp), 6));
}
