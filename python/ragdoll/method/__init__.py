"""The thesis' method on structures: generate, classify, order, resolve, experiment."""
