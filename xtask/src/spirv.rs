//! How does a SPIR-V module forbid contraction, and does it only use what every device computes alike?
#![cfg_attr(not(feature = "shaders"), allow(dead_code))]

pub(crate) const HEADER: usize = 5;
const OP_EXT_INST: u32 = 12;
pub(crate) const OP_DECORATE: u32 = 71;
const OP_FDIV: u32 = 136;
const OP_FUNCTION: u32 = 54;
const NO_CONTRACTION: u32 = 42;

/// SourceContinued, Source, SourceExtension, Name, MemberName, String, Line, NoLine, ModuleProcessed.
const DEBUG: [u32; 9] = [2, 3, 4, 5, 6, 7, 8, 317, 330];
/// Operations that a driver may contract or re-associate: FNegate, FAdd, FSub, FMul, FDiv, FRem, FMod,
/// VectorTimesScalar, MatrixTimesScalar, VectorTimesMatrix, MatrixTimesVector, MatrixTimesMatrix, OuterProduct, Dot.
const FLOAT_OPERATIONS: [u32; 14] = [127, 129, 131, 133, 136, 140, 141, 142, 143, 144, 145, 146, 147, 148];
/// Those of them that no strict module may hold: FRem, FMod and everything that sums products in its own order.
const UNORDERED: [u32; 8] = [140, 141, 143, 144, 145, 146, 147, 148];
/// GLSL.std.450: FAbs, SAbs, Floor, FMin, UMin, SMin, FMax, UMax, SMax, UClamp, SClamp, FindILsb, FindSMsb,
/// FindUMsb, NMin, NMax. FMin and FMax are exact but for NaN, which the kernels that use them keep out.
const EXACT_EXTENDED: [u32; 16] = [4, 5, 8, 37, 38, 39, 40, 41, 42, 44, 45, 73, 74, 75, 79, 80];
/// GLSL.std.450: Sqrt, correctly rounded where the start-up probe says so.
const SQRT: u32 = 31;

/// Word position, opcode and word count of every instruction.
pub(crate) fn instructions(words: &[u32]) -> Result<Vec<(usize, u32, usize)>, String> {
    if words.len() < HEADER || words[0] != 0x0723_0203 {
        return Err("not a SPIR-V module".into());
    }
    let mut list = Vec::new();
    let mut at = HEADER;
    while at < words.len() {
        let count = (words[at] >> 16) as usize;
        if count == 0 || at + count > words.len() {
            return Err(format!("broken instruction at word {at}"));
        }
        list.push((at, words[at] & 0xFFFF, count));
        at += count;
    }
    Ok(list)
}

/// Removes names, lines and sources: what spirv-opt would strip, and would make the bytes depend on folders.
pub fn strip_debug(words: &[u32]) -> Result<Vec<u32>, String> {
    let mut out = words.get(..HEADER).ok_or("not a SPIR-V module")?.to_vec();
    for (at, opcode, count) in instructions(words)? {
        if !DEBUG.contains(&opcode) {
            out.extend(&words[at..at + count]);
        }
    }
    Ok(out)
}

/// Decorates the result of every float operation with `NoContraction`, once.
pub fn forbid_contraction(words: &[u32]) -> Result<Vec<u32>, String> {
    let list = instructions(words)?;
    let decorated = decorated_ids(words, &list);
    let mut decorations = Vec::new();
    for &(at, opcode, _) in &list {
        if FLOAT_OPERATIONS.contains(&opcode) && !decorated.contains(&words[at + 2]) {
            decorations.extend([(3 << 16) | OP_DECORATE, words[at + 2], NO_CONTRACTION]);
        }
    }
    // Annotations stand before the first type; the first of any decoration marks the section.
    let section = list
        .iter()
        .find(|&&(_, opcode, _)| opcode == OP_DECORATE)
        .map(|&(at, _, _)| at)
        .ok_or("the module has no decorations, so no bindings")?;
    let mut out = words[..section].to_vec();
    out.extend(decorations);
    out.extend(&words[section..]);
    Ok(out)
}

/// How many float operations are not decorated with `NoContraction`.
pub fn undecorated(words: &[u32]) -> Result<usize, String> {
    let list = instructions(words)?;
    let decorated = decorated_ids(words, &list);
    Ok(list
        .iter()
        .filter(|&&(at, opcode, _)| FLOAT_OPERATIONS.contains(&opcode) && !decorated.contains(&words[at + 2]))
        .count())
}

fn decorated_ids(words: &[u32], list: &[(usize, u32, usize)]) -> std::collections::HashSet<u32> {
    list.iter()
        .filter(|&&(at, opcode, _)| opcode == OP_DECORATE && words[at + 2] == NO_CONTRACTION)
        .map(|&(at, _, _)| words[at + 1])
        .collect()
}

/// What in the module need not be the same on every device; empty for a module fit for strict mode.
///
/// With `native` division and square root are let through, for devices whose probe shows them correctly rounded.
pub fn inexact(words: &[u32], native: bool) -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    let mut in_function = false;
    for (at, opcode, _) in instructions(words)? {
        in_function |= opcode == OP_FUNCTION;
        if !in_function {
            continue;
        }
        if UNORDERED.contains(&opcode) {
            found.push(format!("operation {opcode} at word {at}"));
        } else if opcode == OP_FDIV && !native {
            found.push(format!("OpFDiv at word {at}"));
        } else if opcode == OP_EXT_INST {
            let function = words[at + 4];
            if !(EXACT_EXTENDED.contains(&function) || (native && function == SQRT)) {
                found.push(format!("GLSL.std.450 instruction {function} at word {at}"));
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A module's header, one binding decoration, and a function with one FMul, one FDiv and one Exp.
    fn sample() -> Vec<u32> {
        let mut words = vec![0x0723_0203, 0x0001_0500, 0, 100, 0];
        words.extend([(4 << 16) | OP_DECORATE, 7, 33, 0]);
        words.extend([(5 << 16) | OP_FUNCTION, 1, 20, 0, 2]);
        words.extend([(5 << 16) | 133, 3, 21, 5, 6]);
        words.extend([(5 << 16) | OP_FDIV, 3, 22, 5, 6]);
        words.extend([(6 << 16) | OP_EXT_INST, 3, 23, 4, 27, 21]);
        words
    }

    #[test]
    fn every_float_operation_gets_the_decoration_once() {
        let words = sample();
        assert_eq!(undecorated(&words), Ok(2));
        let once = forbid_contraction(&words).unwrap();
        assert_eq!(undecorated(&once), Ok(0));
        assert_eq!(once.len(), words.len() + 6);
        assert_eq!(forbid_contraction(&once).unwrap(), once);
    }

    #[test]
    fn debug_information_goes_and_nothing_else() {
        let words = sample();
        let mut with_debug = words[..HEADER].to_vec();
        with_debug.extend([(3 << 16) | 5, 21, 0]);
        with_debug.extend(&words[HEADER..]);
        with_debug.extend([(1 << 16) | 317]);
        assert_eq!(strip_debug(&with_debug).unwrap(), words);
    }

    #[test]
    fn what_devices_round_differently_is_named() {
        assert_eq!(inexact(&sample(), false).unwrap().len(), 2);
        assert_eq!(inexact(&sample(), true).unwrap().len(), 1);
    }

    #[test]
    fn broken_modules_are_refused() {
        assert!(undecorated(&[1, 2, 3]).is_err());
        let mut words = sample();
        words.pop();
        assert!(undecorated(&words).is_err());
    }
}
