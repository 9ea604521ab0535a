// The words of BIP, both notations. No actions: what depends on context is decided in one pass over the token list
// (compiler/parse/classify_tokens.cpp), which also makes the tokens that are declared here without a rule.
// Nothing is unmatchable: unclosed comments and strings and stray characters are tokens too, reported by that pass.
lexer grammar BipLexer;

tokens {
  // `port`, `connector`, `extern` that begin a declaration of a package; `component` likewise
  PORT_DECL, CONNECTOR_DECL, EXTERN_DECL, COMPONENT_DECL,
  // a `[` that does not touch a name: a group in `define`
  GROUP_OPEN,
  // the `else` of `else if` in a chain that one `fi` closes
  ELSE_CHAIN,
  // PARAMS-OR-SPEED-NOT-SET in the paper's notation
  REPORT,
  // `reset c` of a transition, in the older spelling of time; its `when (…)` is PROVIDED
  RESET,
  // `property name { … }` of a compound: the word, and the whole text with its braces, which has a grammar of its own
  PROPERTY, PROPERTY_TEXT
}

// ---- reserved -------------------------------------------------------------------------------------------------------
PACKAGE: 'package'; END: 'end'; USE: 'use'; AS: 'as';
ATOM: 'atom'; COMPOUND: 'compound'; COMPONENT: 'component'; CONNECTOR: 'connector'; PORT: 'port'; TYPE: 'type';
EXTERN: 'extern'; EXPORT: 'export'; FUNCTION: 'function'; OPERATOR: 'operator'; REFINE: 'refine';
DATA: 'data'; CONST: 'const'; DEFINE: 'define'; ON: 'on'; INTERNAL: 'internal';
PROVIDED: 'provided'; DO: 'do'; UP: 'up'; DOWN: 'down';
PLACE: 'place'; INITIAL: 'initial'; FROM: 'from'; TO: 'to'; PRIORITY: 'priority';
IF: 'if'; THEN: 'then'; ELSE: 'else'; FI: 'fi'; TRUE: 'true'; FALSE: 'false';
NATIVE: 'int' | 'bool' | 'float' | 'string';

// ---- contextual: names wherever the grammar has no use for the word ---------------------------------------------------
CLOCK: 'clock'; UNIT: 'unit'; INVARIANT: 'invariant'; AT: 'at'; FINAL: 'final';
LAZY: 'lazy'; DELAYABLE: 'delayable'; EAGER: 'eager'; RESUME: 'resume';
REMEMBER: 'remember'; IGNORE: 'ignore'; ERROR: 'error';
AND_WORD: 'and'; OR_WORD: 'or'; NOT_WORD: 'not';
// these four and `for … in` become plain names in the pass unless what follows makes them keywords
BEHAVIOR: 'behavior' | 'behaviour'; STATE: 'state'; CONTAINS: 'contains';
FOR: 'for'; IN: 'in';

// ---- names and literals -----------------------------------------------------------------------------------------------
ID: [A-Za-z_] [A-Za-z0-9_]*;
// split by the pass into names and minus signs unless it is a report of the paper's notation
DASHED: [A-Z] [A-Z0-9]* ('-' [A-Z] [A-Za-z0-9_]*)+;
// the `0..` of `0..n`: split by the pass
INT_RANGE: [0-9]+ '..';
INT: [0-9]+;
FLOAT: ([0-9]+ '.' [0-9]* | '.' [0-9]+) EXPONENT? | [0-9]+ EXPONENT;
fragment EXPONENT: [eE] [+-]? [0-9]+;
STRING: '"' STRING_CHAR* '"' | '\u201C' ~[\u201D\r\n]* '\u201D';
UNCLOSED_STRING: '"' STRING_CHAR* '\\'?;
fragment STRING_CHAR: ~["\\\r\n] | '\\' ~[\r\n];

// ---- punctuation, with the printed signs of the paper -------------------------------------------------------------------
LPAREN: '('; RPAREN: ')'; LBRACK: '['; RBRACK: ']'; LBRACE: '{'; RBRACE: '}';
COMMA: ','; SEMI: ';'; ELLIPSIS: '\u2026' | '.' [ \t]* '.' [ \t]* '.'; DOTDOT: '..'; DOT: '.'; AT_SIGN: '@';
ARROW: ':=' | '\u2190'; COLON: ':';
SUBSCRIPT: [\u2080-\u2089]+ | '\u2099';
PRIME: '\'' | '\u2019' | '\u2032';
OROR: '||' | '\u2228'; ANDAND: '&&' | '\u2227';
EQ: '=='; NE: '!=' | '\u2260'; LE: '<=' | '\u2264'; GE: '>=' | '\u2265'; LT: '<'; GT: '>'; ASSIGN: '=';
PIPE: '|'; CARET: '^'; AMP: '&'; PLUS: '+'; MINUS: '-' | '\u2212'; STAR: '*'; SLASH: '/'; PERCENT: '%';
BANG: '!' | '\u00AC'; TILDE: '~';

// ---- what no parser sees ------------------------------------------------------------------------------------------------
LINE_COMMENT: '//' ~[\r\n]*;
BLOCK_COMMENT: '/*' .*? '*/';
UNCLOSED_COMMENT: '/*' (~'*' | '*'+ ~[*/])* '*'*;
SPACE: [ \t\r\n\f\u00A0]+ -> skip;
STRAY: .;
