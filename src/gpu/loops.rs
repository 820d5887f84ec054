//! Proves that a shader's loops end, so that it may run without a guard in every turn of every loop.
//!
//! wgpu otherwise counts the turns of each loop and leaves it after 2^64. Drivers then unroll little, and a network's
//! kernels, which are short loops over registers, compile and run several times slower.

use naga::{BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, Module, Statement};

/// Bounds and steps up to this cannot overflow their counter.
const MOST: i64 = 1 << 30;

/// Whether every loop of `module` is `for (var i = ..; i < B; i += S)` with constants B and S > 0, and nothing but
/// its head changes i.
pub(crate) fn all_counted(module: &Module) -> bool {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    functions.chain(entries).all(|function| counted_in(function, &function.body))
}

fn counted_in(function: &Function, block: &Block) -> bool {
    block.iter().all(|statement| match statement {
        Statement::Loop { body, continuing, break_if } => {
            break_if.is_none() && is_counted(function, body, continuing) && counted_in(function, body)
        }
        Statement::Block(inner) => counted_in(function, inner),
        Statement::If { accept, reject, .. } => counted_in(function, accept) && counted_in(function, reject),
        Statement::Switch { cases, .. } => cases.iter().all(|case| counted_in(function, &case.body)),
        _ => true,
    })
}

fn is_counted(function: &Function, body: &Block, continuing: &Block) -> bool {
    let Some(counter) = counter_of(function, body) else { return false };
    counts_up(function, continuing, counter) && !changes(function, body, counter)
}

/// The variable i of a loop that begins with `if !(i < B) { break; }`, freshly evaluated.
fn counter_of(function: &Function, body: &Block) -> Option<Handle<LocalVariable>> {
    let mut fresh = Vec::new();
    for statement in body.iter() {
        match statement {
            Statement::Emit(range) => fresh.extend(range.clone()),
            Statement::If { condition, accept, reject } => {
                let breaks = accept.is_empty() && matches!(reject.first(), Some(Statement::Break));
                let Expression::Binary { op: BinaryOperator::Less, left, right } =
                    &function.expressions[*condition]
                else {
                    return None;
                };
                let Expression::Load { pointer } = &function.expressions[*left] else { return None };
                let bound = integer(function, *right)?;
                let evaluated = fresh.contains(condition) && fresh.contains(left);
                return local(function, *pointer).filter(|_| breaks && evaluated && bound <= MOST);
            }
            _ => return None,
        }
    }
    None
}

/// Whether the block adds a positive constant to `counter`, once, and does nothing else to it.
fn counts_up(function: &Function, continuing: &Block, counter: Handle<LocalVariable>) -> bool {
    let stores = continuing.iter().filter(|statement| !matches!(statement, Statement::Emit(_)));
    let stores: Vec<_> = stores.collect();
    let [Statement::Store { pointer, value }] = stores.as_slice() else { return false };
    let Expression::Binary { op: BinaryOperator::Add, left, right } = &function.expressions[*value] else {
        return false;
    };
    let Expression::Load { pointer: from } = &function.expressions[*left] else { return false };
    let step = integer(function, *right).is_some_and(|step| (1..=MOST).contains(&step));
    step && local(function, *pointer) == Some(counter) && local(function, *from) == Some(counter)
}

/// Whether `block` stores to `counter` or hands out its address.
fn changes(function: &Function, block: &Block, counter: Handle<LocalVariable>) -> bool {
    let is_counter = |pointer: &Handle<Expression>| local(function, *pointer) == Some(counter);
    block.iter().any(|statement| match statement {
        Statement::Emit(_)
        | Statement::Break
        | Statement::Continue
        | Statement::Kill
        | Statement::Atomic { .. }
        | Statement::ImageStore { .. }
        | Statement::Return { .. } => false,
        Statement::Block(inner) => changes(function, inner, counter),
        Statement::If { accept, reject, .. } => {
            changes(function, accept, counter) || changes(function, reject, counter)
        }
        Statement::Loop { body, continuing, .. } => {
            changes(function, body, counter) || changes(function, continuing, counter)
        }
        Statement::Store { pointer, .. } => is_counter(pointer),
        Statement::Call { arguments, .. } => arguments.iter().any(is_counter),
        Statement::SubgroupGather { .. } | Statement::SubgroupCollectiveOperation { .. } => false,
        // What is not known to leave it alone may change it.
        _ => true,
    })
}

fn local(function: &Function, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
    match function.expressions[pointer] {
        Expression::LocalVariable(variable) => Some(variable),
        _ => None,
    }
}

fn integer(function: &Function, value: Handle<Expression>) -> Option<i64> {
    match function.expressions[value] {
        Expression::Literal(Literal::I32(value)) => Some(value.into()),
        Expression::Literal(Literal::U32(value)) => Some(value.into()),
        _ => None,
    }
}
