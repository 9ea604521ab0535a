"""Strong components of a graph, for the oracles of this folder. `following`: by node, the nodes that its edges lead to."""


def components(nodes, following):
    """Strong components by Kosaraju's two passes."""
    order, seen = [], set()
    for root in nodes:
        if root in seen:
            continue
        seen.add(root)
        stack = [(root, iter(following[root]))]
        while stack:
            node, rest = stack[-1]
            for to in rest:
                if to in following and to not in seen:
                    seen.add(to)
                    stack.append((to, iter(following[to])))
                    break
            else:
                stack.pop()
                order.append(node)
    before = {node: [] for node in nodes}
    for node in nodes:
        for to in following[node]:
            if to in before:
                before[to].append(node)
    done, found = set(), []
    for root in reversed(order):
        if root in done:
            continue
        done.add(root)
        own, todo = [root], [root]
        while todo:
            for to in before[todo.pop()]:
                if to not in done:
                    done.add(to)
                    own.append(to)
                    todo.append(to)
        found.append(own)
    return found
