"""Stages and summaries of suspensions: the tensor along the flow, interaction, content."""
