"""Commands that run programs: files, scripts, the prompt, teaching, the demonstration.

Which file decides what:

    run          which kind of program a file is; Python scripts
    run_program  program files: rehearsal, output, journal, and resuming
    run_person   the person's input during a run: Enter, pauses, a second Ctrl-C
    run_arm      the arm of a run: its table, its speed, its recording
    run_output   what is printed while a program runs
    shell        reading and completing lines at a prompt
    teach        a program recorded as another program moves the arm
    pendant      the program in an arm's own memory, and when it is overwritten
    demo         the demonstration
    arguments    the options of all of them, and the text of their help
"""
