"""Many runs: axes and cases, what a case is known by, where results live, and the engine that runs them."""
