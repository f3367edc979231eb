//! Finding the part of a tree that a place means.

use crate::diag::Span;
use crate::syntax::{Expr, ExprKind, Statement, Tree};

/// Shows `see` all statements of a file, those within braces behind the one that holds them.
pub fn each_statement<'t>(tree: &'t Tree, see: &mut dyn FnMut(&'t Statement)) {
    let mut waiting: Vec<&'t [Statement]> = vec![&tree.statements];
    while let Some(statements) = waiting.pop() {
        for statement in statements {
            see(statement);
            statement.each_part(&mut |_| {}, &mut |inner| waiting.push(inner));
        }
    }
}

/// The innermost statement around `span` that `is` accepts.
pub fn statement<'t>(tree: &'t Tree, span: Span, is: impl Fn(&Statement) -> bool) -> Option<&'t Statement> {
    let mut found: Option<&'t Statement> = None;
    each_statement(tree, &mut |statement| {
        let around = statement.span.start <= span.start && span.end <= statement.span.end;
        let inner = found.is_none_or(|outer| outer.span.start <= statement.span.start);
        if around && inner && is(statement) {
            found = Some(statement);
        }
    });
    found
}

/// Shows `see` all expressions of a file.
fn each_expr<'t>(tree: &'t Tree, see: &mut dyn FnMut(&'t Expr)) {
    let mut waiting: Vec<&'t Expr> = Vec::new();
    each_statement(tree, &mut |statement| statement.each_part(&mut |expr| waiting.push(expr), &mut |_| {}));
    while let Some(expr) = waiting.pop() {
        see(expr);
        expr.each_part(&mut |part| waiting.push(part));
    }
}

/// The expression that is exactly `span`.
pub fn expr(tree: &Tree, span: Span) -> Option<&Expr> {
    let mut found = None;
    each_expr(tree, &mut |expr| {
        if expr.span == span {
            found = Some(expr);
        }
    });
    found
}

/// The argument of a call that is exactly `span`.
pub fn argument(tree: &Tree, span: Span) -> Option<&Expr> {
    let mut found = None;
    each_expr(tree, &mut |expr| {
        if let ExprKind::Call(call) = &expr.kind {
            found = call.args.iter().map(|arg| &arg.value).find(|value| value.span == span).or(found);
        }
    });
    found
}
