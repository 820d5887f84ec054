//! Proves that a shader's loops end, so that it may run without a guard in every turn of every loop.
//!
//! wgpu otherwise counts the turns of each loop and leaves it after 2^64. Drivers then unroll little, and a network's
//! kernels, which are short loops over registers, compile and run several times slower.

use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction, Module,
    Statement,
};

/// Bounds and steps up to this cannot overflow their counter.
const MOST: i64 = 1 << 30;

/// Whether every loop of `module` is `for (var i = ..; i < B; i += S)` with a constant S > 0, and nothing but its head changes
/// i; B is constant or `min(.., C)` too unless S is 1, as no number is above the largest, which i then comes to; or
/// `for (var i = ..; i > 0u; i--)`.
pub(crate) fn all_counted(module: &Module) -> bool {
    let functions = module.functions.iter().map(|(_, function)| function);
    let entries = module.entry_points.iter().map(|entry| &entry.function);
    functions.chain(entries).all(|function| Proof { module, function }.counted_in(&function.body))
}

/// What a counter is compared with.
#[derive(Clone, Copy)]
enum Bound {
    /// `i < B`.
    Below(Handle<Expression>),
    /// `i > 0u`.
    AboveZero,
}

/// Of one function.
#[derive(Clone, Copy)]
struct Proof<'a> {
    module: &'a Module,
    function: &'a Function,
}

impl<'a> Proof<'a> {
    fn counted_in(self, block: &Block) -> bool {
        block.iter().all(|statement| match statement {
            Statement::Loop { body, continuing, break_if } => {
                break_if.is_none() && self.is_counted(body, continuing) && self.counted_in(body)
            }
            Statement::Block(inner) => self.counted_in(inner),
            Statement::If { accept, reject, .. } => self.counted_in(accept) && self.counted_in(reject),
            Statement::Switch { cases, .. } => cases.iter().all(|case| self.counted_in(&case.body)),
            _ => true,
        })
    }

    fn is_counted(self, body: &Block, continuing: &Block) -> bool {
        let Some((counter, bound)) = self.counter_of(body) else { return false };
        let counts = match bound {
            Bound::Below(bound) => {
                let most = if self.most(bound).is_some_and(|bound| bound <= MOST) { MOST } else { 1 };
                self.counts(continuing, counter, BinaryOperator::Add, most)
            }
            Bound::AboveZero => self.counts(continuing, counter, BinaryOperator::Subtract, 1),
        };
        counts && !self.changes(body, counter)
    }

    /// The variable i of a loop that begins with `if !(i < B) { break; }` or `if !(i > 0u) { break; }`, freshly evaluated, and
    /// which it is; each turn comes to it.
    fn counter_of(self, body: &Block) -> Option<(Handle<LocalVariable>, Bound)> {
        let mut fresh = Vec::new();
        for statement in body.iter() {
            match statement {
                Statement::Emit(range) => fresh.extend(range.clone()),
                // What the bound is put together from.
                statement if goes_on(statement) => {}
                Statement::If { condition, accept, reject } => {
                    let breaks = accept.is_empty() && matches!(reject.first(), Some(Statement::Break));
                    let Expression::Binary { op, left, right } = *self.of(*condition) else { return None };
                    let bound = match (op, self.of(right)) {
                        (BinaryOperator::Less, _) => Bound::Below(right),
                        (BinaryOperator::Greater, Expression::Literal(Literal::U32(0))) => Bound::AboveZero,
                        _ => return None,
                    };
                    let Expression::Load { pointer } = *self.of(left) else { return None };
                    let evaluated = fresh.contains(condition) && fresh.contains(&left);
                    let counter = self.local(pointer).filter(|_| breaks && evaluated)?;
                    return Some((counter, bound));
                }
                _ => return None,
            }
        }
        None
    }

    /// Whether the block adds or subtracts a constant from 1 to `most`, once, and does nothing else to `counter`.
    fn counts(
        self,
        continuing: &Block,
        counter: Handle<LocalVariable>,
        wanted: BinaryOperator,
        most: i64,
    ) -> bool {
        let stores = continuing.iter().filter(|statement| !matches!(statement, Statement::Emit(_)));
        let stores: Vec<_> = stores.collect();
        let [Statement::Store { pointer, value }] = stores.as_slice() else { return false };
        let Expression::Binary { op, left, right } = *self.of(*value) else { return false };
        let Expression::Load { pointer: from } = *self.of(left) else { return false };
        let step = self.integer(right).is_some_and(|step| (1..=most).contains(&step));
        op == wanted && step && self.local(*pointer) == Some(counter) && self.local(from) == Some(counter)
    }

    /// Whether `block` stores to `counter` or hands out its address.
    fn changes(self, block: &Block, counter: Handle<LocalVariable>) -> bool {
        let is_counter = |pointer: &Handle<Expression>| self.local(*pointer) == Some(counter);
        block.iter().any(|statement| match statement {
            Statement::Emit(_)
            | Statement::Break
            | Statement::Continue
            | Statement::Kill
            | Statement::Atomic { .. }
            | Statement::ImageStore { .. }
            | Statement::ControlBarrier(_)
            | Statement::MemoryBarrier(_)
            | Statement::Return { .. } => false,
            Statement::Block(inner) => self.changes(inner, counter),
            Statement::If { accept, reject, .. } => {
                self.changes(accept, counter) || self.changes(reject, counter)
            }
            Statement::Loop { body, continuing, .. } => {
                self.changes(body, counter) || self.changes(continuing, counter)
            }
            Statement::Store { pointer, .. } => is_counter(pointer),
            Statement::Call { arguments, .. } => arguments.iter().any(is_counter),
            Statement::SubgroupGather { .. } | Statement::SubgroupCollectiveOperation { .. } => false,
            // What is not known to leave it alone may change it.
            _ => true,
        })
    }

    fn of(self, expression: Handle<Expression>) -> &'a Expression {
        &self.function.expressions[expression]
    }

    fn local(self, pointer: Handle<Expression>) -> Option<Handle<LocalVariable>> {
        match *self.of(pointer) {
            Expression::LocalVariable(variable) => Some(variable),
            _ => None,
        }
    }

    /// What the value cannot be above: itself where it is constant, or a constant of `min(.., ..)`.
    fn most(self, value: Handle<Expression>) -> Option<i64> {
        match *self.of(value) {
            Expression::Math { fun: MathFunction::Min, arg, arg1: Some(other), .. } => {
                self.integer(arg).into_iter().chain(self.integer(other)).min()
            }
            _ => self.integer(value),
        }
    }

    fn integer(self, value: Handle<Expression>) -> Option<i64> {
        let literal = match *self.of(value) {
            Expression::Constant(constant) => {
                &self.module.global_expressions[self.module.constants[constant].init]
            }
            ref other => other,
        };
        match *literal {
            Expression::Literal(Literal::I32(value)) => Some(value.into()),
            Expression::Literal(Literal::U32(value)) => Some(value.into()),
            _ => None,
        }
    }
}

/// Whether the statement after this one runs next, however this one turns out.
fn goes_on(statement: &Statement) -> bool {
    match statement {
        Statement::Emit(_) | Statement::Store { .. } | Statement::Call { .. } => true,
        Statement::Block(inner) => inner.iter().all(goes_on),
        Statement::If { accept, reject, .. } => accept.iter().chain(reject.iter()).all(goes_on),
        _ => false,
    }
}
