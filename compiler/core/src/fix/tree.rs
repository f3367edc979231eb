//! Finding the part of a tree that a place means. A file may have a hundred thousand statements, and as many findings: nothing here
//! looks at more than the statements around the place.

use crate::diag::Span;
use crate::syntax::{Expr, ExprKind, Statement, Tree};

/// The statements around `span`, outermost first.
fn around(tree: &Tree, span: Span) -> Vec<&Statement> {
    let mut found = Vec::new();
    let mut lists: Vec<&[Statement]> = vec![&tree.statements];
    while let Some(list) = lists.pop() {
        let behind = list.partition_point(|statement| statement.span.start <= span.start);
        let Some(statement) = behind.checked_sub(1).map(|at| &list[at]).filter(|one| span.end <= one.span.end) else {
            continue;
        };
        found.push(statement);
        statement.each_part(&mut |_| {}, &mut |inner| lists.push(inner));
    }
    found
}

/// The innermost statement around `span` that `is` accepts.
pub fn statement(tree: &Tree, span: Span, is: impl Fn(&Statement) -> bool) -> Option<&Statement> {
    around(tree, span).into_iter().rev().find(|statement| is(statement))
}

/// Shows `see` the expressions in the statement around `span`.
fn each_expr<'t>(tree: &'t Tree, span: Span, see: &mut dyn FnMut(&'t Expr)) {
    let mut waiting: Vec<&'t Expr> = Vec::new();
    for statement in around(tree, span) {
        statement.each_part(&mut |expr| waiting.push(expr), &mut |_| {});
    }
    while let Some(expr) = waiting.pop() {
        if expr.span.start <= span.start && span.end <= expr.span.end {
            see(expr);
            expr.each_part(&mut |part| waiting.push(part));
        }
    }
}

/// The argument of a call that is exactly `span`.
pub fn argument(tree: &Tree, span: Span) -> Option<&Expr> {
    let mut found = None;
    each_expr(tree, span, &mut |expr| {
        if let ExprKind::Call(call) = &expr.kind {
            found = call.args.iter().map(|arg| &arg.value).find(|value| value.span == span).or(found);
        }
    });
    found
}
