/* musl asks for it; wasm32 needs nothing of it. */
