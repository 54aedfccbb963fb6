//! Writes the JSON Schema of move files to standard output: `cargo run -p motion-move --features schema --example schema`.

fn main() {
    println!("{:#}", motion_move::schema());
}
