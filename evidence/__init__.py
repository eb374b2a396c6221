"""The evidence of the documents: a file for each question, which runs the kernel, writes its numbers and draws. `python -m
evidence` lists the questions with what each takes."""
