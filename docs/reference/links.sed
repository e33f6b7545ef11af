# Doxygen's filter for pages: of their links those stay that lead to pages of the reference.
/^```/,/^```/ b
s/\]\(([a-z./]*\/)?(embedding[a-z-]*|main)\.md(#[a-z-]+)?\)/]{{\1\2.md}}/g
s/\[([^]]*)\]\([^)]*\)/\1/g
s/\{\{/(/g
s/\}\}/)/g
