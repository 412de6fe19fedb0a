//! Analytic materials and a virtual goniophotometer: known truth for tests, demo and benches.
