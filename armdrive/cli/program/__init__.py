"""Commands that run programs: files, scripts, the prompt, teaching, the demonstration."""
