//! Prints the numbers of `src/sh/triple_products.rs` and `src/sh/rotation_tables.rs`, computed in float64.

#[path = "../tests/oracle/sh.rs"]
mod sh_oracle;

fn main() {
    for (i, j, k, v) in sh_oracle::triples(5) {
        println!("{i} {j} {k} {:?}", v as f32);
    }
    for d in sh_oracle::lobe_directions() {
        println!("LOBE {:?}", d.map(|x| x as f32));
    }
    for l in 1..5 {
        for row in sh_oracle::lobe_matrix(l) {
            println!("M{l} {:?}", row.iter().map(|&x| x as f32).collect::<Vec<_>>());
        }
    }
}
