"""Commands that run programs: files, scripts, the prompt, teaching, the demonstration.

What is decided where:

    run          which kind of program a file is; Python scripts
    run_program  program files: rehearsed, shown, their journal, and how they are resumed
    run_common   what a person does meanwhile: Enter, a pause, and what a second Ctrl-C does
    run_output   what is printed while a program runs
    shell        reading and completing lines at a prompt
    teach        recording, editing and running sequences; what is made of them
    pendant      the program in an arm's own memory, and when it is overwritten
    demo         the demonstration
    arguments    the options of all of them, and the text of their help
"""
