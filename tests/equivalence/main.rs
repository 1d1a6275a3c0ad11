//! Do the CPU and the GPU give the same bits, pass by pass?
//!
//! One test body, instantiated for each pass of the list; a pass without inputs in `cases` does not compile. Every pass
//! runs on the CPU with one and with two threads, and on the GPU with each strict variant: the same bits. The fast
//! variant must stay within the tolerance that the pass declares. Outputs start as poison, of which nothing may
//! be left, and nothing beyond them may change. On the same outputs the comparison must object to planted faults.

#[path = "../common/mod.rs"]
mod common;

mod body;
mod cases;
mod totality;

use body::{Case, Launch, check};
use common::draw::Draw;
use totality::{Floats, spoil};
use twinlight::backend::{Backend, BackendError};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::info;

macro_rules! equivalence {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        /// The inputs of each pass, under the pass's name.
        #[allow(non_camel_case_types)]
        mod case {
            use super::*;
            $(
                $(#[$doc])*
                pub struct $name {
                    pub launch: Launch,
                    pub params: $params,
                    $(pub $input: Vec<$element>,)*
                }

                impl Case for $name {
                    type Output = $out;

                    fn launch(&self) -> &Launch { &self.launch }

                    fn spoil(&mut self, floats: Floats, draw: &mut Draw) -> usize {
                        let _ = (floats, &draw);
                        0 $(+ spoil(&mut self.$input, floats, draw))*
                    }

                    fn run<B: Backend>(&self, backend: &mut B, start: &[$out]) -> Result<Vec<$out>, BackendError> {
                        $(let $input = backend.upload(stringify!($input), &self.$input)?;)*
                        let mut output = backend.upload("output", start)?;
                        backend.$name(&self.params, $(&$input,)* &mut output, self.launch.items)?;
                        backend.download(&output)
                    }
                }
            )*
        }

        $(
            #[test]
            fn $name() {
                let mut draw = Draw::new(stringify!($name));
                let inputs: Vec<case::$name> = cases::$name(&mut draw);
                check(&info::$name, &inputs, &mut draw);
            }
        )*

        /// Any floats: nothing breaks, nothing is endless, nothing that is not finite comes out.
        mod any_floats {
            use super::*;
            $(
                #[test]
                fn $name() {
                    let mut draw = Draw::new(concat!(stringify!($name), " of any floats"));
                    totality::check(&info::$name, cases::$name, &mut draw);
                }
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(equivalence);
